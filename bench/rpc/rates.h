#pragma once
#include "measure.h"

namespace genphys::bench {

/// How much goes over the wire where many things travel in one message.
struct Rates {
  Spread forces_cpp;      // per second, in columns of kRateRows
  Spread forces_python;   // the same from numpy arrays
  Spread creations;       // entities per second, in batches of kRateRows
  Spread frame_to_numpy;  // us, from the bytes of a frame of kRateRows entities to its columns as arrays
  Spread small_frames;    // per second, of one entity, pushed to a Python viewer of a world that plays
  Spread unwatched;       // ns per body and step that a served step costs beyond one in process while nobody looks
};

inline constexpr uint32_t kRateRows = 1000;

/// Progress goes to standard error. Failures are std::runtime_errors.
Rates MeasureRates(const Parties& parties, const std::string& engine);

}  // namespace genphys::bench

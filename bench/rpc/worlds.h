#pragma once
#include <cstddef>
#include <string>

#include "measure.h"

namespace genphys::bench {

/// Many worlds stepped by one call of StepWorlds, against one thread that steps the same worlds in process.
struct WorldsOutcome {
  std::string engine;
  size_t worlds = 0;
  size_t bodies = 0;  // of each
  int rounds = 0;
  double others = 0;   // most that others used in a round that counts, in processors
  Spread one_thread;   // of a step of all worlds
  Spread step_worlds;  // of the same as a call, with the frames and events of all
  Spread speedup;      // the first over the second, in each round
};

/// Progress goes to standard error. Failures, and worlds that come to another state than in process, are
/// std::runtime_errors.
WorldsOutcome MeasureWorlds(const Parties& parties, const std::string& engine, const Plan& plan);

}  // namespace genphys::bench

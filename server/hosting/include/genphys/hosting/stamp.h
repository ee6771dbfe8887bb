#pragma once
#include <cstdint>
#include <optional>

#include "genphys/v1/types.pb.h"

namespace genphys {

/// When something was true; see WorldStamp in the contract.
struct Stamp {
  uint64_t step = 0;
  double simulation_time = 0;  // s
  uint64_t epoch = 0;
  std::optional<uint64_t> state_hash;

  void Encode(v1::WorldStamp* out) const;
};

/// A number that no other epoch has had, as far as chance goes; never zero.
uint64_t NewEpoch();

}  // namespace genphys

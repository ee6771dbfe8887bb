#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

namespace genphys {

/// Where a step's work went: EXPLAIN for physics. Of the last Step().
struct StepStats {
  struct Stage {
    std::string_view name;
    uint64_t nanoseconds = 0;
  };
  uint32_t entities_asleep = 0;
  uint32_t entities_in_flight = 0;  // moved by the layer alone
  uint32_t entities_in_engine = 0;
  uint32_t pairs = 0;     // touching or nearly so
  uint32_t contacts = 0;  // points
  uint32_t islands = 0;   // of those in the engine: groups that touch or are joined; who does neither is one
  std::vector<Stage> stages;
};

}  // namespace genphys

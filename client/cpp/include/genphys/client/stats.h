#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace genphys::client {

/// Where the work of a step went.
struct Stats {
  struct Stage {
    std::string name;
    uint64_t nanoseconds = 0;
  };
  uint32_t entities_asleep = 0;
  uint32_t entities_in_flight = 0;
  uint32_t entities_in_engine = 0;
  uint32_t pairs = 0;
  uint32_t contacts = 0;
  uint32_t islands = 0;
  std::vector<Stage> stages;
};

/// That for people: a few lines with a table of the stages, their times and their shares of the whole.
std::string Explain(const Stats& stats);

}  // namespace genphys::client

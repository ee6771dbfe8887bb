#include "genphys/client/stats.h"

#include <algorithm>
#include <cstdio>

namespace genphys::client {
namespace {

std::string Line(const std::string& name, size_t width, uint64_t nanoseconds, uint64_t total) {
  const double part = total == 0 ? 0 : static_cast<double>(nanoseconds) / static_cast<double>(total);
  char numbers[64];
  std::snprintf(numbers, sizeof numbers, "%12.1f us %5.1f %%\n", 1e-3 * static_cast<double>(nanoseconds), 100 * part);
  return name + std::string(width - name.size(), ' ') + numbers;
}

}  // namespace

std::string Explain(const Stats& stats) {
  const std::string total_name = "step";
  size_t width = total_name.size();
  uint64_t total = 0;
  for (const Stats::Stage& stage : stats.stages) {
    width = std::max(width, stage.name.size());
    total += stage.nanoseconds;
  }
  std::string text = "entities: " + std::to_string(stats.entities_asleep) + " asleep, " +
                     std::to_string(stats.entities_in_flight) + " in flight, " +
                     std::to_string(stats.entities_in_engine) + " in the engine\n" +
                     "touching: " + std::to_string(stats.pairs) + " pairs, " + std::to_string(stats.contacts) +
                     " contacts, " + std::to_string(stats.islands) + " islands\n";
  for (const Stats::Stage& stage : stats.stages) text += Line(stage.name, width, stage.nanoseconds, total);
  return text + Line(total_name, width, total, total);
}

}  // namespace genphys::client

#pragma once
#include <string>
#include <utility>
#include <vector>

#include "genphys/registry.h"
#include "measure.h"
#include "rates.h"
#include "worlds.h"

namespace genphys::bench {

/// All that one run found out.
struct Results {
  std::vector<Outcome> outcomes;
  std::vector<WorldsOutcome> worlds;
  std::vector<std::pair<std::string, Rates>> rates;  // by engine
  std::string date;                                  // as Now() tells it
  std::string python_versions;                       // a JSON object, as python_client.py prints it
  double load_before = 0;                            // load average of the minute before
};

/// As JSON, with a description of the machine and of what ran on it that names neither.
std::string ToJson(const Results& results, const BackendRegistry& registry);

}  // namespace genphys::bench

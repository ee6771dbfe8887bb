#pragma once
#include <string>
#include <vector>

#include "case.h"
#include "genphys/registry.h"

namespace genphys::bench {

/// All that one run found out.
struct Results {
  std::string date;        // as Now() tells it
  double load_before = 0;  // load average of the minute before
  std::vector<Outcome> outcomes;
};

/// As JSON, with the titles of `cases` and a description of the machine that does not name it.
std::string ToJson(const Results& results, const std::vector<Case>& cases, const BackendRegistry& registry);

/// What one scene came to, as lines for people: costs with their lanes, figures with their bars.
std::string ToText(const Outcome& outcome);

}  // namespace genphys::bench

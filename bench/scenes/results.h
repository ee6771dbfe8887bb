#pragma once
#include <string>
#include <vector>

#include "case.h"
#include "genphys/registry.h"
#include "measure.h"

namespace genphys::bench {

/// All that one run found out.
struct Results {
  std::string date;        // as Now() tells it
  double load_before = 0;  // load average of the minute before
  std::vector<Outcome> outcomes;
};

/// As JSON, with what `cases` say of the scenes and a description of the machine that does not name it.
std::string ToJson(const Results& results, const std::vector<Case>& cases, const BackendRegistry& registry);

/// What one scene came to, as lines for people.
std::string ToText(const Outcome& outcome, const Case& what);

}  // namespace genphys::bench

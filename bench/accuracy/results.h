#pragma once
#include <limits>
#include <string>
#include <vector>

#include "genphys/registry.h"
#include "measure.h"
#include "problem.h"

namespace genphys::bench {

/// All that one run found out.
struct Results {
  std::vector<Result> results;
  std::string date;                                              // as Now() tells it
  double calibration = std::numeric_limits<double>::infinity();  // least of all, s
};

/// As JSON, with the problems and a description of the machine that does not name it.
std::string ToJson(const Results& results, const std::vector<Problem>& problems, const BackendRegistry& registry);

}  // namespace genphys::bench

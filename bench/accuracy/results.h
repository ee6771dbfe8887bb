#pragma once
#include <limits>
#include <map>
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
  std::map<std::string, std::string> peers;                      // what Peer::about tells, by contender
};

/// Whose results: of our model and the engines alone, or of peers.
enum class Part { kOurs, kPeers };

/// As JSON, with the problems and a description of the machine that does not name it.
std::string ToJson(const Results& results, Part part, const std::vector<Problem>& problems,
                   const BackendRegistry& registry);

}  // namespace genphys::bench

#pragma once
#include <optional>
#include <string>
#include <vector>

#include "contenders/contender.h"
#include "problem.h"

namespace genphys::bench {

/// One contender on one problem with one step size.
struct Result {
  std::string problem;
  std::string contender;
  int rate = 0;                      // steps per second
  std::vector<Quantity> quantities;  // "error" first; empty: it failed, or only the cost counts
  std::string failure;               // why there is no answer
  double cpu = 0;                    // processor time per simulated second, s; zero: not measured
};

/// What a contender comes to.
Result Solve(const Problem& problem, const Contender& contender, int rate);

/// Measures the processor time of each contender, in turns, `rounds` of them, and keeps each one's least in `results`,
/// which must be of one problem and rate. Returns the least time of the calibration in between, s.
double Time(const Problem& problem, const std::vector<const Contender*>& contenders, int rate, int rounds,
            std::vector<Result>& results);

/// The quantity of that name, if `result` has it.
std::optional<double> Find(const Result& result, const std::string& quantity);

}  // namespace genphys::bench

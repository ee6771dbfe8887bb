#pragma once
#include <string>
#include <vector>

#include "measure.h"

namespace genphys::bench {

/// What one contender has to reach on one problem.
struct Bar {
  enum class Kind {
    kQuantity,  // at most `limit`
    kOrder,     // of convergence between 1/480 and 1/2000 s, at least `limit`
    kCost,      // processor time, at most `limit` times that of the engine alone
  };
  Kind kind = Kind::kQuantity;
  std::string problem;
  std::string quantity;    // of Kind::kQuantity
  std::vector<int> rates;  // steps per second; empty: all of the problem
  double limit = 0;
  std::string contender;
  std::string against;  // of Kind::kCost: another contender
};

/// All that `script/bench accuracy --bars` looks at.
std::vector<Bar> Bars();

/// One line for each bar that `results` have something to say about; returns how many were missed.
int PrintBars(const std::vector<Result>& results);

}  // namespace genphys::bench

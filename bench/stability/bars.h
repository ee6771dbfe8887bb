#pragma once
#include <string>
#include <vector>

#include "results.h"

namespace genphys::bench {

/// What one contender has to reach in one trial, with any of its step sizes.
struct Bar {
  std::string trial;
  std::string contender;
  std::string quantity;
  double largest = 0;
};

/// All that `script/bench stability --bars` looks at.
std::vector<Bar> Bars();

/// One line for each bar that `outcomes` have something to say about; returns how many were missed.
int PrintBars(const std::vector<Outcome>& outcomes);

}  // namespace genphys::bench

#pragma once
#include <cstddef>
#include <vector>

namespace genphys::bench {

/// Of many values of one thing.
struct Spread {
  size_t count = 0;
  double p10 = 0;
  double median = 0;
  double p90 = 0;
};

/// `values` has one at least.
Spread SpreadOf(const std::vector<double>& values);
double Median(const std::vector<double>& values);
double Mean(const std::vector<double>& values);

}  // namespace genphys::bench

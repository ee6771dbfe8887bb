#include "spread.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace genphys::bench {
namespace {

double Quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  const double place = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<size_t>(place);
  const size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - std::floor(place)) * (values[above] - values[below]);
}

}  // namespace

double Median(const std::vector<double>& values) { return Quantile(values, 0.5); }

double Mean(const std::vector<double>& values) {
  return std::reduce(values.begin(), values.end()) / static_cast<double>(values.size());
}

Spread SpreadOf(const std::vector<double>& values) {
  return {values.size(), Quantile(values, 0.1), Median(values), Quantile(values, 0.9)};
}

}  // namespace genphys::bench

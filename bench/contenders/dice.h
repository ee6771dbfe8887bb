#pragma once
#include <cmath>
#include <cstdint>
#include <random>

#include "genphys/math.h"

namespace genphys::bench {

/// Numbers that are the same everywhere, which the distributions of the standard library are not.
class Dice {
 public:
  explicit Dice(uint32_t seed) : generator_(seed) {}

  /// From -1 to 1.
  double Next() { return 2.0 * static_cast<double>(generator_()) / static_cast<double>(std::mt19937::max()) - 1; }
  double Between(double low, double high) { return low + (high - low) * (Next() + 1) / 2; }
  /// The same with a uniform logarithm; both positive.
  double LogBetween(double low, double high) { return std::exp(Between(std::log(low), std::log(high))); }
  /// Each coordinate from -1 to 1.
  Vector3 NextVector() {
    const double x = Next(), y = Next(), z = Next();
    return {x, y, z};
  }

 private:
  std::mt19937 generator_;
};

}  // namespace genphys::bench

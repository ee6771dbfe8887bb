#pragma once
#include <cstdint>
#include <random>

#include "genphys/math.h"

namespace genphys::testing {

/// Numbers that a seed says, the same with every standard library.
class Random {
 public:
  explicit Random(uint64_t seed) : generator_(seed) {}

  /// From `low` to `high`.
  double Uniform(double low, double high);
  /// The same with a uniform logarithm; both positive.
  double LogUniform(double low, double high);
  /// 0 to `count` - 1.
  size_t Below(size_t count);
  bool Chance(double probability);
  /// Each component from -`bound` to `bound`.
  Vector3 Vector(double bound);
  Vector3 Direction();
  Quaternion Turn();

 private:
  std::mt19937_64 generator_;
};

}  // namespace genphys::testing

#include "support/random.h"

#include <cmath>

namespace genphys::testing {

double Random::Uniform(double low, double high) {
  constexpr double kOf53Bits = 0x1p-53;
  return low + (high - low) * static_cast<double>(generator_() >> 11) * kOf53Bits;
}

double Random::LogUniform(double low, double high) { return std::exp(Uniform(std::log(low), std::log(high))); }

size_t Random::Below(size_t count) { return static_cast<size_t>(generator_() % count); }

bool Random::Chance(double probability) { return Uniform(0, 1) < probability; }

Vector3 Random::Vector(double bound) {
  const double x = Uniform(-bound, bound), y = Uniform(-bound, bound), z = Uniform(-bound, bound);
  return {x, y, z};
}

Vector3 Random::Direction() {
  while (true) {
    const Vector3 inside = Vector(1);
    const double length = inside.norm();
    if (length > 0.1 && length <= 1) return inside / length;
  }
}

Quaternion Random::Turn() {
  const double angle = Uniform(-M_PI, M_PI);
  return Quaternion(Eigen::AngleAxisd(angle, Direction()));
}

}  // namespace genphys::testing

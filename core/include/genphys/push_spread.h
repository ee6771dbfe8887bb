#pragma once
#include <algorithm>
#include <cstddef>
#include <limits>

#include "genphys/math.h"

namespace genphys {

/// How differently what lies in an island answers to pushes. Where something heavy lies on something light, sweeps come
/// no nearer to what bears it.
class PushSpread {
 public:
  /// From this on it is uneven, and solved all at once while that is little work.
  static constexpr double kUneven = 50;

  /// Of a push at `arm` (m) from a centre of mass, in whatever direction. `inverse_inertia` (1/(kg*m^2)) is the norm of
  /// the inverse tensor.
  void Note(const Vector3& arm, double inverse_mass, double inverse_inertia) {
    const double mobility = inverse_mass + arm.squaredNorm() * inverse_inertia;
    easiest_ = std::max(easiest_, mobility);
    hardest_ = std::min(hardest_, mobility);
  }

  /// How many times more one of them moves what it meets than another one; 1 if there was none.
  double Value() const { return easiest_ > 0 ? easiest_ / hardest_ : 1; }

 private:
  double easiest_ = 0;  // 1/kg
  double hardest_ = std::numeric_limits<double>::infinity();
};

}  // namespace genphys

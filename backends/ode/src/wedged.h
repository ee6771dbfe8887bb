#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "genphys/math.h"

namespace genphys::ode_backend {

/// Which bodies of a solve slide along surfaces that face different ways, as along a floor and a wall. What holds one
/// across its way on the one is pressed by the other.
class Wedged {
 public:
  /// For `count` bodies that touch nothing yet.
  void Begin(size_t count) {
    normals_.assign(count, Vector3::Zero());
    wedged_.assign(count, false);
  }

  /// Of a contact that slides, of unit length. A body beyond the count is none of the solve.
  void Note(uint32_t body, const Vector3& normal) {
    // The cosine of an angle that is more than rounding makes of one surface, about one degree.
    constexpr double kSame = 0.9998;
    if (body >= normals_.size()) return;
    if (normals_[body].isZero(0)) normals_[body] = normal;
    if (std::abs(normals_[body].dot(normal)) < kSame) wedged_[body] = true;
  }

  bool operator[](uint32_t body) const { return body < wedged_.size() && wedged_[body] != 0; }

 private:
  std::vector<Vector3> normals_;  // of the first contact that slides, by body
  std::vector<uint8_t> wedged_;
};

}  // namespace genphys::ode_backend

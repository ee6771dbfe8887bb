#pragma once
#include "genphys/math.h"

namespace genphys {

/// Volume, centre and inertia of the solid inside a closed surface of triangles: the sum of the tetrahedra between each
/// triangle and one reference point, with signs (divergence theorem, as in B. Mirtich, Fast and Accurate Computation
/// of Polyhedral Mass Properties, 1996, with the second moments of a tetrahedron in closed form).
class Polyhedron {
 public:
  /// The nearer `reference` is to the solid, the less is lost to rounding.
  explicit Polyhedron(const Vector3& reference) : reference_(reference) {}

  /// Corners anticlockwise as seen from outside, m.
  void Add(const Vector3& a, const Vector3& b, const Vector3& c) {
    const Vector3 p = a - reference_, q = b - reference_, r = c - reference_;
    const double volume = p.dot(q.cross(r)) / 6;
    const Vector3 sum = p + q + r;
    volume_ += volume;
    first_ += volume / 4 * sum;
    second_ += volume / 20 * (sum * sum.transpose() + p * p.transpose() + q * q.transpose() + r * r.transpose());
  }

  /// m^3.
  double volume() const { return volume_; }
  /// Of mass, m.
  Vector3 center() const { return reference_ + first_ / volume_; }
  /// About the centre for unit density, m^5.
  Matrix3 tensor() const {
    const Matrix3 covariance = second_ - first_ * first_.transpose() / volume_;
    return covariance.trace() * Matrix3::Identity() - covariance;
  }

 private:
  Vector3 reference_;
  double volume_ = 0;
  Vector3 first_ = Vector3::Zero();
  Matrix3 second_ = Matrix3::Zero();
};

}  // namespace genphys

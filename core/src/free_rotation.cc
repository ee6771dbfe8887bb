#include "free_rotation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace genphys {
namespace {

// Radians per inner step at which the fourth-order error stays near rounding for the bodies of a step of 1/60 s.
constexpr double kAngleMax = 0.8;
// Bounds the work for a body at the limits of spin and step size; beyond it accuracy is lost, not stability.
constexpr int kInnerStepsMax = 4096;
// Turning less than this in a step, the spin changes by less than rounding can show in the orientation.
constexpr double kNegligibleAngle = 1e-8;
// The sine of an angle that is no more than rounding.
constexpr double kParallel = 1e-14;

Vector3 Spin(const Column4& q, const Vector3& momentum, const Matrix3& inverse_tensor) {
  const Quaternion orientation = FromColumn(q).normalized();
  return orientation * (inverse_tensor * (orientation.conjugate() * momentum));
}

// dq/dt = 1/2 w q, with w following from the conserved momentum.
Column4 Rate(const Column4& q, const Vector3& momentum, const Matrix3& inverse_tensor) {
  const Vector3 w = Spin(q, momentum, inverse_tensor);
  return 0.5 * ToColumn(Quaternion(0, w.x(), w.y(), w.z()) * FromColumn(q));
}

// The rotation vector of `turn` on the branch nearest to `expected`, which may exceed half a turn.
Vector3 Logarithm(const Quaternion& turn, const Vector3& expected) {
  const double sine = turn.vec().norm();
  if (sine < 1e-300) return Vector3::Zero();
  const Vector3 axis = turn.vec() / sine;
  const double angle = 2 * std::atan2(sine, turn.w());
  const double whole = 2 * std::numbers::pi;
  return (angle + whole * std::round((expected.dot(axis) - angle) / whole)) * axis;
}

}  // namespace

Quaternion Turned(const Quaternion& orientation, const Vector3& spin, double time) {
  const double angle = spin.norm() * time;
  if (angle == 0) return orientation;
  return (Quaternion(Eigen::AngleAxisd(angle, spin.normalized())) * orientation).normalized();
}

Matrix3 WorldTensor(const Quaternion& orientation, const Matrix3& tensor) {
  const Matrix3 rotation = orientation.toRotationMatrix();
  return rotation * tensor * rotation.transpose();
}

Vector3 MeanFreeSpin(const Quaternion& orientation, const Vector3& momentum, const Matrix3& inverse_tensor,
                     double time) {
  const Column4 start = ToColumn(orientation);
  const Vector3 spin = Spin(start, momentum, inverse_tensor);
  if (spin.norm() * time < kNegligibleAngle) return spin;
  // About a principal axis it goes on as it is.
  if (momentum.cross(spin).norm() <= kParallel * momentum.norm() * spin.norm()) return spin;
  const double steps = std::floor(spin.norm() * time / kAngleMax) + 1;
  const int count = static_cast<int>(std::min<double>(steps, kInnerStepsMax));
  const double h = time / count;
  Column4 q = start;
  Vector3 expected = Vector3::Zero();
  for (int i = 0; i < count; ++i) {
    expected += h * Spin(q, momentum, inverse_tensor);
    const Column4 k1 = Rate(q, momentum, inverse_tensor);
    const Column4 k2 = Rate(q + h / 2 * k1, momentum, inverse_tensor);
    const Column4 k3 = Rate(q + h / 2 * k2, momentum, inverse_tensor);
    const Column4 k4 = Rate(q + h * k3, momentum, inverse_tensor);
    q += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    q.normalize();
  }
  return Logarithm(FromColumn(q) * orientation.conjugate(), expected) / time;
}

}  // namespace genphys

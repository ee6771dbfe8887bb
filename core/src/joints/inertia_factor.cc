#include "joints/inertia_factor.h"

#include <algorithm>
#include <cmath>

namespace genphys {
namespace {

// Beyond it numbers do not suffice for an engine, and nothing of the model is pulled so hard.
constexpr double kFactorMax = 1e12;

}  // namespace

Matrix3 PullStiffness(const Vector3& arm, const Vector3& force) {
  const Matrix3 product = arm * force.transpose();
  return arm.dot(force) * Matrix3::Identity() - (product + product.transpose()) / 2;
}

double SwingOf(const Matrix3& inverse_tensor, const Matrix3& stiffness, double h) {
  // The eigenvalues are real, so that none is larger than the root of the sum of their squares.
  const Matrix3 product = inverse_tensor * stiffness;
  return h * h * std::sqrt((product * product).trace());
}

double InertiaFactor(double swing) {
  if (!std::isfinite(swing) || swing <= kResolvedSwing) return 1;
  return std::min(swing / kResolvedSwing, kFactorMax);
}

}  // namespace genphys

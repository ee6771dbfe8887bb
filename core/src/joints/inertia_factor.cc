#include "joints/inertia_factor.h"

#include <algorithm>
#include <cmath>

namespace genphys {
namespace {

// Beyond it numbers do not suffice for an engine, and nothing of the model is pulled so hard.
constexpr double kFactorMax = 1e12;

}  // namespace

Matrix3 PullStiffness(const Vector3& arm, const Vector3& force) {
  Matrix3 stiffness;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < i; ++k) stiffness(i, k) = stiffness(k, i) = -(arm[i] * force[k] + arm[k] * force[i]) / 2;
  }
  const Vector3 along = arm.cwiseProduct(force);
  stiffness.diagonal() = Vector3(along.y() + along.z(), along.z() + along.x(), along.x() + along.y());
  return stiffness;
}

double SwingOf(const Matrix3& inverse_tensor, const Matrix3& stiffness, double h) {
  // The eigenvalues are real, so that none is larger than the root of the sum of their squares.
  const Matrix3 product = inverse_tensor * stiffness;
  return h * h * std::sqrt(product.cwiseProduct(product.transpose()).sum());
}

double InertiaFactor(double swing) {
  if (!std::isfinite(swing) || swing <= kResolvedSwing) return 1;
  return std::min(swing / kResolvedSwing, kFactorMax);
}

}  // namespace genphys

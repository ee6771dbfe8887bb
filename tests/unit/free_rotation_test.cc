#include "core/src/free_rotation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace genphys {
namespace {

Quaternion Turned(const Quaternion& orientation, const Vector3& spin, double time) {
  const double angle = spin.norm() * time;
  if (angle == 0) return orientation;
  return (Quaternion(Eigen::AngleAxisd(angle, spin.normalized())) * orientation).normalized();
}

// A symmetric top precesses at L / I_across about its momentum and spins at (1/I_along - 1/I_across) L_along about its
// own axis (Goldstein, Classical Mechanics, 5.6).
TEST(MeanFreeSpin, FollowsTheClosedFormOfASymmetricTop) {
  constexpr double kAcross = 1, kAlong = 1.8, kTime = 1.0 / 60;
  constexpr int kSteps = 600;
  constexpr double kRungeKuttaError = 2e-6;  // rad after 10 s: 0.05^5 / 120 at each of 600 steps
  const Matrix3 tensor = Vector3(kAcross, kAcross, kAlong).asDiagonal();
  const Vector3 momentum = tensor * Vector3(0.5, 0, 3);  // orientation begins as identity
  Quaternion orientation = Quaternion::Identity();

  for (int i = 0; i < kSteps; ++i) {
    orientation = Turned(orientation, MeanFreeSpin(orientation, momentum, tensor.inverse(), kTime), kTime);
  }

  const double time = kTime * kSteps;
  const double own = (1 / kAlong - 1 / kAcross) * momentum.z() * time;
  const Quaternion expected = Quaternion(Eigen::AngleAxisd(momentum.norm() / kAcross * time, momentum.normalized())) *
                              Quaternion(Eigen::AngleAxisd(own, Vector3::UnitZ()));
  EXPECT_LE(orientation.angularDistance(expected), kRungeKuttaError);
}

TEST(MeanFreeSpin, OfABallIsItsSpinAlsoBeyondHalfATurn) {
  constexpr double kTime = 0.25;
  const Vector3 spin(0, 0, 100);  // 25 rad in one step

  const Vector3 mean = MeanFreeSpin(Quaternion::Identity(), 0.4 * spin, Matrix3::Identity() / 0.4, kTime);

  // The inner steps are 0.8 rad at most: 0.8^5 / 120 of error at each of 32.
  EXPECT_LE((mean - spin).norm(), 4e-3 * spin.norm());
}

TEST(MeanFreeSpin, OfABodyAtRestIsNothing) {
  EXPECT_EQ(MeanFreeSpin(Quaternion::Identity(), Vector3::Zero(), Matrix3::Identity(), 0.01), Vector3(0, 0, 0));
}

}  // namespace
}  // namespace genphys

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

// Classical Runge-Kutta of Euler's equations with so many steps that it resolves all that its momentum could do.
Quaternion Reference(const Vector3& spin, const Matrix3& tensor, double time) {
  constexpr int kSteps = 400'000;
  const Matrix3 inverse = tensor.inverse();
  const Vector3 momentum = tensor * spin;
  const auto rate = [&](const Column4& q) -> Column4 {
    const Vector3 own = inverse * (FromColumn(q).conjugate() * momentum);
    return ToColumn(FromColumn(q) * Quaternion(0, own.x(), own.y(), own.z())) / 2;
  };
  const double h = time / kSteps;
  Column4 q = ToColumn(Quaternion::Identity());
  for (int i = 0; i < kSteps; ++i) {
    const Column4 k1 = rate(q), k2 = rate(q + h / 2 * k1), k3 = rate(q + h / 2 * k2), k4 = rate(q + h * k3);
    q = (q + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)).normalized();
  }
  return FromColumn(q);
}

TEST(FreeRotation, OfWhatIsLongAndThinIsThatOfEulersEquations) {
  constexpr double kTime = 1.0 / 60, kFine = 1e-9;  // rad
  // A lath of 2 m by 2 cm by 1.2 cm, and a rod.
  const Vector3 lath(4.533e-5, 0.333345, 0.333367), rod(5e-5, 0.3333, 0.3333);
  const Matrix3 askew = Quaternion(Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized())).toRotationMatrix();
  for (const Vector3& moments : {lath, rod}) {
    for (const Matrix3& axes : {Matrix3(Matrix3::Identity()), askew}) {
      for (const Vector3& own : {Vector3(2, 20, 0.1), Vector3(-30, 3, 4), Vector3(0.01, 5, 5)}) {
        MassProperties mass;
        mass.tensor = axes * moments.asDiagonal() * axes.transpose();
        mass.inverse_tensor = mass.tensor.inverse();
        const Vector3 spin = axes * own, momentum = mass.tensor * spin;
        const Quaternion expected = Reference(spin, mass.tensor, kTime);

        const FreeRotation free(Quaternion::Identity(), spin, mass, kTime);
        EXPECT_LE(free.orientation.angularDistance(expected), kFine)
            << moments.transpose() << " by " << own.transpose();
        EXPECT_NEAR(free.spin.dot(momentum), spin.dot(momentum), 1e-8 * spin.dot(momentum));
        const Vector3 mean = MeanFreeSpin(Quaternion::Identity(), momentum, mass.inverse_tensor, kTime);
        EXPECT_LE(Turned(Quaternion::Identity(), mean, kTime).angularDistance(expected), kFine);
      }
    }
  }
}

TEST(MeanFreeSpin, OfABodyAtRestIsNothing) {
  EXPECT_EQ(MeanFreeSpin(Quaternion::Identity(), Vector3::Zero(), Matrix3::Identity(), 0.01), Vector3(0, 0, 0));
}

}  // namespace
}  // namespace genphys

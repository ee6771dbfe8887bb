#include "core/src/motion/free_rotation.h"

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

// Euler's equations in principal axes (Goldstein, Classical Mechanics, 5.5) by classical Runge-Kutta: there nothing is
// faster than the spin, however thin the body is.
Quaternion Reference(const Vector3& own_spin, const Vector3& moments, double time) {
  constexpr int kSteps = 2'000;  // of 3e-4 rad: 3e-4^5 / 120 of error at each
  struct Top {
    Vector3 spin;  // rad/s, own axes
    Column4 turn;
  };
  const auto rate = [&](const Top& top) -> Top {
    const Vector3& w = top.spin;
    const Vector3 torque = (moments.asDiagonal() * w).cross(w);
    return {torque.cwiseQuotient(moments), ToColumn(FromColumn(top.turn) * Quaternion(0, w.x(), w.y(), w.z())) / 2};
  };
  const auto after = [](const Top& top, double h, const Top& change) -> Top {
    return {top.spin + h * change.spin, top.turn + h * change.turn};
  };
  const double h = time / kSteps;
  Top top{own_spin, ToColumn(Quaternion::Identity())};
  for (int i = 0; i < kSteps; ++i) {
    const Top k1 = rate(top), k2 = rate(after(top, h / 2, k1)), k3 = rate(after(top, h / 2, k2));
    const Top k4 = rate(after(top, h, k3));
    top = after(after(after(after(top, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
  }
  return FromColumn(top.turn).normalized();
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
        const Quaternion to_axes(axes);
        const Quaternion expected = to_axes * Reference(own, moments, kTime) * to_axes.conjugate();

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

// The longest inner step is taken where a body turns by just that in a step: there the error of each adds up for
// longest.
TEST(MeanFreeSpin, KeepsTheEnergyOfWhatTurnsFastForAHundredThousandSteps) {
  constexpr double kTime = 1.0 / 240;
  for (const Vector3& moments : {Vector3(0.77, 0.13, 0.67), Vector3(0.22, 1, 0.82), Vector3(2, 3, 4)}) {
    const Matrix3 tensor = moments.asDiagonal(), inverse = tensor.inverse();
    for (const double spin : {18.0, 21.0, 23.0, 24.8, 28.0}) {
      const Vector3 first = spin * Vector3(0.5, 0.7, 0.4).normalized(), momentum = tensor * first;
      Quaternion orientation = Quaternion::Identity();
      const auto energy = [&] {
        const Vector3 own = orientation.conjugate() * momentum;
        return own.dot(inverse * own) / 2;
      };
      const double before = energy();
      for (int i = 0; i < 100'000; ++i) {
        orientation = Turned(orientation, MeanFreeSpin(orientation, momentum, inverse, kTime), kTime);
      }
      EXPECT_NEAR(energy() / before, 1, 1e-10) << moments.transpose() << " at " << spin;
    }
  }
}

// Of each inner step of half a radian the fifth power is what it misses, and that is given back to first order.
TEST(MeanFreeSpin, KeepsTheEnergyOfWhatTurnsByThousandsOfRadiansHoweverFewStepsItIsGiven) {
  constexpr double kTime = 0.25;
  const Matrix3 askew = Quaternion(Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized())).toRotationMatrix();
  for (const Vector3& moments : {Vector3(0.77, 0.13, 0.67), Vector3(0.22, 1, 0.82), Vector3(2, 3, 4)}) {
    const Matrix3 tensor = askew * moments.asDiagonal() * askew.transpose(), inverse = tensor.inverse();
    for (const double spin : {100.0, 1e3, 3e3, 1e4}) {
      for (const int steps_max : {16, 128}) {
        const Vector3 momentum = tensor * (spin * Vector3(0.5, 0.7, 0.4).normalized());
        const Vector3 mean = MeanFreeSpin(Quaternion::Identity(), momentum, inverse, kTime, steps_max);
        const Vector3 own = Turned(Quaternion::Identity(), mean, kTime).conjugate() * momentum;
        EXPECT_NEAR(own.dot(inverse * own) / momentum.dot(inverse * momentum), 1, 1e-3)
            << moments.transpose() << " at " << spin << " in " << steps_max;
      }
    }
  }
}

TEST(MeanFreeSpin, OfWhatIsBlurredIsItsSpin) {
  const Matrix3 inverse = Vector3(2, 3, 5).asDiagonal();
  for (const double spin : {1e5, 1e12, 1e30}) {
    const Vector3 first = spin * Vector3(0.5, 0.7, 0.4);
    const Vector3 mean = MeanFreeSpin(Quaternion::Identity(), inverse.inverse() * first, inverse, 0.25, 128);
    EXPECT_TRUE(IsBlurred(first.norm(), 0.25));
    EXPECT_LE((mean - first).norm(), 1e-12 * spin);
  }
  EXPECT_FALSE(IsBlurred(1e4, 0.25)) << "worlds let that be";
}

TEST(MeanFreeSpin, OfABodyAtRestIsNothing) {
  EXPECT_EQ(MeanFreeSpin(Quaternion::Identity(), Vector3::Zero(), Matrix3::Identity(), 0.01), Vector3(0, 0, 0));
}

}  // namespace
}  // namespace genphys

#include "core/src/joints/inertia_factor.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace genphys {
namespace {

constexpr double kRounding = 1e-9;

TEST(PullStiffness, IsHowTheTorqueOfAForceChangesWithTheTurn) {
  // The difference quotient is off by a second derivative, |arm| |force| times the turn.
  constexpr double kTurn = 1e-6, kTolerance = 2e-5;
  const Vector3 arm(0.3, -0.2, 0.5), force(4, 7, -2);
  Matrix3 change;
  for (int i = 0; i < 3; ++i) {
    const Vector3 turned = Eigen::AngleAxisd(kTurn, Vector3::Unit(i)) * arm;
    change.col(i) = (turned.cross(force) - arm.cross(force)) / kTurn;
  }
  EXPECT_LE((PullStiffness(arm, force) + (change + change.transpose()) / 2).norm(), kTolerance);
}

TEST(SwingOf, IsNotLessThanTheFastest) {
  // 10 rad/s about both axes across.
  const double swing = SwingOf(Matrix3::Identity(), PullStiffness({0, 0, 1}, {0, 0, 100}), 0.01);
  EXPECT_GE(swing, 0.01);
  EXPECT_LE(swing, std::sqrt(2) * 0.01 + kRounding);
}

TEST(InertiaFactor, IsOneWhereTheStepResolvesTheSwing) {
  EXPECT_EQ(InertiaFactor(0), 1);
  EXPECT_EQ(InertiaFactor(0.99 * kResolvedSwing), 1);
  EXPECT_GT(InertiaFactor(1.01 * kResolvedSwing), 1);
}

TEST(InertiaFactor, SlowsTheSwingDownToWhatAStepResolves) {
  constexpr double kStep = 1.0 / 120;
  // A link of 0.1 kg and 0.1 m between ends that pull with 1,000 N.
  const Matrix3 tensor = Vector3(8e-5, 8e-5, 5e-6).asDiagonal();
  const Matrix3 stiffness = PullStiffness({0, 0, 0.05}, {0, 0, 1000}) + PullStiffness({0, 0, -0.05}, {0, 0, -1000});
  const double factor = InertiaFactor(SwingOf(tensor.inverse(), stiffness, kStep));
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix3> swings(stiffness, Matrix3(factor * tensor));
  const double swing = swings.eigenvalues().maxCoeff() * kStep * kStep;
  EXPECT_LE(swing, kResolvedSwing);
  // Both swings across are alike, so that the bound is the root of two of the fastest.
  EXPECT_NEAR(swing, kResolvedSwing / std::sqrt(2), kRounding);
}

TEST(InertiaFactor, IsOneForNumbersThatAreNone) {
  EXPECT_EQ(InertiaFactor(std::nan("")), 1);
  EXPECT_EQ(InertiaFactor(std::numeric_limits<double>::infinity()), 1);
  EXPECT_LE(InertiaFactor(1e300), 1e12);
}

}  // namespace
}  // namespace genphys

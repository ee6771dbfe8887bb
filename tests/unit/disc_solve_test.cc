// Friction that is bounded along two lines, turned until it is in its disc.
#include "core/src/contacts/disc_solve.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "core/src/contacts/solver_rows.h"

namespace genphys {
namespace {

// Sweeps come to an end by themselves.
class NoSolver final : public BoundedSolver {
 public:
  bool Solve(const Eigen::MatrixXd&, const Eigen::VectorXd&, std::span<const Bounds>, Eigen::VectorXd&) override {
    ADD_FAILURE();
    return false;
  }
};

// A point that presses with `pressing` N*s: its friction for each way that it is pushed.
Eigen::Vector2d FrictionOf(const Eigen::Matrix2d& mobility, const Eigen::Vector2d& wanted, double pressing,
                           double coefficient) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(3, 3);
  matrix.bottomRightCorner<2, 2>() = mobility;
  const Eigen::VectorXd all = (Eigen::VectorXd(3) << pressing, wanted).finished();
  const BoundedSolver::Bounds bounds[] = {
      {0, INFINITY}, {-coefficient, coefficient, 0}, {-coefficient, coefficient, 0}};
  const Eigen::Index pairs[] = {1};
  NoSolver solver;
  Eigen::VectorXd impulses = Eigen::VectorXd::Zero(3);
  EXPECT_TRUE(DiscSolve(solver, matrix, all, bounds, pairs).Run(impulses));
  return impulses.tail<2>();
}

TEST(DiscSolve, FrictionOfAPointIsTheNearestInItsDisc) {
  const Eigen::Matrix2d mobility{{2, 0.4}, {0.4, 1}};
  constexpr double kPressing = 3, kCoefficient = 0.5;
  for (const double push : {0.1, 1.0, 2.5, 3.5, 10.0, 1e3}) {
    for (double angle = 0; angle < 6.3; angle += 0.1) {
      const Eigen::Vector2d wanted = push * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      const Eigen::Vector2d nearest = NearestInDisc(mobility, wanted, kCoefficient * kPressing);
      // See kAgrees.
      EXPECT_LE((FrictionOf(mobility, wanted, kPressing, kCoefficient) - nearest).norm(),
                2 * 1e-5 * kCoefficient * kPressing)
          << push << " at " << angle;
    }
  }
}

TEST(DiscSolve, WhatDoesNotPressHasNoFriction) {
  EXPECT_EQ(FrictionOf(Eigen::Matrix2d::Identity(), {3, 4}, -1, 0.5), Eigen::Vector2d::Zero());
}

}  // namespace
}  // namespace genphys

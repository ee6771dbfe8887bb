#pragma once
#include <span>

#include "genphys/math.h"

namespace genphys {

/// How an engine solves rows whose impulses have bounds, all of them at once.
class BoundedSolver {
 public:
  static constexpr int kFree = -1;

  /// From `lower` to `upper` (N*s or N*m*s; no infinite interval), or from so many times the impulse of the row
  /// `bounded_by` to so many.
  struct Bounds {
    double lower, upper;
    int bounded_by = kFree;
  };

  virtual ~BoundedSolver() = default;

  /// Finds `impulses` within their bounds, so that the rates `matrix` * impulses are as `wanted` (m/s or rad/s) where
  /// an impulse is inside of its bounds, no lower where it is at the lower one and no higher at the upper one. `matrix`
  /// is symmetric and positive definite. What presses may be taken for the bounds of friction as it is without any.
  /// False: there is no solution in sight, and `impulses` mean nothing.
  virtual bool Solve(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& wanted, std::span<const Bounds> bounds,
                     Eigen::VectorXd& impulses) = 0;
};

}  // namespace genphys

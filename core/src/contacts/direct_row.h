#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "genphys/bounded_solver.h"

namespace genphys {

/// A row of a direct solve.
struct DirectRow {
  /// What it has to do with one of its bodies.
  struct Part {
    uint32_t body;
    Eigen::Vector4d linear, angular;            // of the Jacobian
    Eigen::Vector4d linear_gain, angular_gain;  // velocity per impulse

    /// How the row's rate changes with an impulse of another row on the same body.
    double Answer(const Part& to) const { return linear.dot(to.linear_gain) + angular.dot(to.angular_gain); }
  };

  double* impulse;
  double foretold;               // N*s or N*m*s: about what it may come to
  BoundedSolver::Bounds bounds;  // `bounded_by` is the number of another row
  double wanted;                 // m/s or rad/s
  double softness;               // 1/kg or 1/(kg*m^2)
  double slack;                  // the part of it that is no spring's
  bool is_first_of_two = false;  // with the next one it is bounded together, as friction is whichever way it acts
  Part a, b;

  bool is_free() const {
    return bounds.bounded_by == BoundedSolver::kFree && std::isinf(bounds.lower) && std::isinf(bounds.upper);
  }
};

}  // namespace genphys

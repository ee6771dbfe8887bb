#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "genphys/bounded_solver.h"
#include "genphys/friction_disc.h"

namespace genphys {

/// Equations whose impulses have bounds, solved at once: by sweeps where these soon come to an end, else by the engine.
/// Both bound each impulse by itself, so that what is bounded together is solved anew with other lines until it is.
class DiscSolve {
 public:
  using Bounds = BoundedSolver::Bounds;

  /// As BoundedSolver::Solve() takes them. Each of `pairs` is the first of two rows across each other, one after the
  /// other, which have the same bounds together: so many times the impulse of another row.
  DiscSolve(BoundedSolver& solver, const Eigen::MatrixXd& matrix, const Eigen::VectorXd& wanted,
            std::span<const Bounds> bounds, std::span<const Eigen::Index> pairs);

  /// Starts from `impulses`. False: there is no solution in sight.
  bool Run(Eigen::VectorXd& impulses);

 private:
  // A row that is bounded by another one, or two.
  struct Friction {
    Eigen::Index row;
    bool is_pair;
    FrictionDisc disc;
  };

  // Returns the worst, m/s or rad/s.
  double Follow(const Eigen::VectorXd& impulses);
  // To the lines of the discs, or `back` from there.
  void Turn(bool back, Eigen::VectorXd& vector) const;
  bool SolveTurned(Eigen::VectorXd& impulses) const;

  BoundedSolver& solver_;
  const Eigen::MatrixXd& matrix_;
  const Eigen::VectorXd& wanted_;
  std::span<const Bounds> bounds_;
  std::vector<Friction> frictions_;
};

}  // namespace genphys

#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "contacts/direct_row.h"
#include "contacts/law_solve.h"
#include "contacts/solver_rows.h"
#include "genphys/bounded_solver.h"

namespace genphys {

/// Rows, solved all at once: by LawSolve, or else those without bounds by elimination, and what they leave of the
/// others as DiscSolve does.
class DirectSolve {
 public:
  using Bounds = BoundedSolver::Bounds;

  /// Starts with no rows, for what happens to `changes`, by body.
  void Begin(std::span<MotionChange> changes) {
    changes_ = changes;
    rows_.clear();
  }

  /// Adds a row of which a solve wants `wanted` (see SolverRow), with the number of another one as what it is bounded
  /// by, which has given `impulse` and gives what that is after; `foretold` is about that, as far as anybody knows.
  /// `softness` is 1/kg or 1/(kg*m^2), `slack` is added to it, of its mobility.
  void Add(const SolverRow& row, double wanted, const Bounds& bounds, double softness, double slack, double& impulse,
           double foretold);

  /// The last row, and the next one across it, are bounded together, as friction is whichever way it acts.
  void PairLast() { rows_.back().is_first_of_two = true; }

  /// Gives all rows their impulses and the bodies what follows. False, and nothing done: there is no solution in sight.
  /// `bounded`, if there is one, is asked where nothing else helps.
  bool Run(BoundedSolver* bounded);

 private:
  using Row = DirectRow;
  using Part = DirectRow::Part;

  static double Dot(const Part& x, const Part& y);
  bool RunByLaws();
  bool RunByElimination(BoundedSolver& bounded);
  Eigen::MatrixXd Matrix(const std::vector<size_t>& of, const std::vector<size_t>& by) const;
  Eigen::VectorXd Wanted(const std::vector<size_t>& of) const;
  bool SolveBounded(BoundedSolver& solver, const Eigen::MatrixXd& matrix, const Eigen::VectorXd& wanted,
                    const std::vector<size_t>& bounded, Eigen::VectorXd& impulses) const;
  // Whether impulses are so large that they are none.
  bool IsJammed(const std::vector<size_t>& rows, const Eigen::VectorXd& impulses) const;
  void Apply(const std::vector<size_t>& rows, const Eigen::VectorXd& impulses);

  std::span<MotionChange> changes_;
  std::vector<Row> rows_;
  LawSolve laws_;
};

}  // namespace genphys

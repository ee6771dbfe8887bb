#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "contacts/solver_rows.h"
#include "genphys/bounded_solver.h"

namespace genphys {

/// Rows, solved all at once: those without bounds by elimination, and what they leave of the others as DiscSolve does.
class DirectSolve {
 public:
  using Bounds = BoundedSolver::Bounds;

  /// For what happens to `changes`, by body.
  DirectSolve(BoundedSolver& solver, std::span<MotionChange> changes) : solver_(solver), changes_(changes) {}

  /// Adds a row of which a solve wants `wanted` (see SolverRow), with the number of another one as what it is bounded
  /// by, and which starts from `impulse` and has it after.
  /// `softness` is 1/kg or 1/(kg*m^2), `slack` is added to it, of its mobility.
  void Add(const SolverRow& row, double wanted, const Bounds& bounds, double softness, double slack, double& impulse);

  /// The last row, and the next one across it, are bounded together, as friction is whichever way it acts.
  void PairLast() { rows_.back().is_first_of_two = true; }

  /// Gives all rows their impulses and the bodies what follows. False, and nothing done: there is no solution in sight.
  bool Run();

 private:
  struct Part {
    uint32_t body;
    Eigen::Vector4d linear, angular;            // of the row's Jacobian
    Eigen::Vector4d linear_gain, angular_gain;  // velocity per impulse
  };
  struct Row {
    double* impulse;
    Bounds bounds;
    double wanted;    // m/s or rad/s
    double softness;  // 1/kg or 1/(kg*m^2)
    double slack;     // the part of it that is no spring's
    bool is_first_of_two = false;
    Part a, b;
  };

  static double Dot(const Part& x, const Part& y);
  Eigen::MatrixXd Matrix(const std::vector<size_t>& of, const std::vector<size_t>& by) const;
  Eigen::VectorXd Wanted(const std::vector<size_t>& of) const;
  bool SolveBounded(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& wanted, const std::vector<size_t>& bounded,
                    Eigen::VectorXd& impulses) const;
  // Whether impulses are so large that they are none.
  bool IsJammed(const std::vector<size_t>& rows, const Eigen::VectorXd& impulses) const;
  void Apply(const std::vector<size_t>& rows, const Eigen::VectorXd& impulses);

  BoundedSolver& solver_;
  std::span<MotionChange> changes_;
  std::vector<Row> rows_;
};

}  // namespace genphys

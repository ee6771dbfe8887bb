#pragma once
#include <BulletDynamics/ConstraintSolver/btSolverBody.h>
#include <BulletDynamics/ConstraintSolver/btSolverConstraint.h>

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "contact_rows.h"

namespace genphys::bullet_backend {

/// Rows of Bullet's sequential solver, solved all at once: those without bounds by elimination, and what they leave of
/// the others by sweeps that find out which are at their bounds, in turns with the elimination of those which are not
/// (Silcowitz, Niebe, Erleben: Projected Gauss-Seidel subspace minimization method, 2010). Bullet's own direct solvers
/// share a flag between all threads, so that a world could end the solve of another.
class DirectSolve {
 public:
  static constexpr int kFree = -1;

  /// What is solved for: what bodies go on with, or what pushes overlapping ones apart and does not stay with them.
  enum class Of { kVelocities, kPushes };

  DirectSolve(btAlignedObjectArray<btSolverBody>& bodies, Of of) : bodies_(bodies), of_(of) {}

  /// From `lower` to `upper` N*s or N*m*s, or so many times the impulse of the row that was added as `bounded_by`.
  struct Bounds {
    double lower, upper;
    int bounded_by = kFree;
  };

  /// Adds a row of velocities with its own bounds as that says; `softness` is added to its own, of its mobility.
  void Add(btSolverConstraint& row, int bounded_by, double softness);
  /// Adds a row of a contact for what is solved for: `wanted` and `impulse` are of that.
  void Add(const ContactRow& row, double wanted, const Bounds& bounds, double softness, double& impulse);

  /// Gives all rows their impulses and the bodies what follows. False, and nothing done: there is no solution in sight.
  bool Run();

 private:
  struct Part {
    int body;
    btVector3 linear, angular;            // of the row's Jacobian
    btVector3 linear_gain, angular_gain;  // velocity per impulse
  };
  struct Row {
    double* impulse;
    Bounds bounds;
    double wanted;    // m/s or rad/s
    double softness;  // 1/kg or 1/(kg*m^2)
    double slack;     // the part of it that is no spring's
    Part a, b;
  };

  void Add(const Bounds& bounds, double softness, Row row);
  static double Dot(const Part& x, const Part& y);
  Eigen::MatrixXd Matrix(const std::vector<size_t>& of, const std::vector<size_t>& by) const;
  Eigen::VectorXd Wanted(const std::vector<size_t>& of) const;
  void SolveBounded(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& wanted, const std::vector<size_t>& bounded,
                    Eigen::VectorXd& impulses) const;
  // What the row may have, where those that bound others have `impulses`.
  std::pair<double, double> BoundsOf(const Row& row, const std::vector<Eigen::Index>& place,
                                     const Eigen::VectorXd& impulses) const;
  // Whether impulses are so large that they are none.
  bool IsJammed(const std::vector<size_t>& rows, const Eigen::VectorXd& impulses) const;
  void Apply(const std::vector<size_t>& rows, const Eigen::VectorXd& impulses);

  btAlignedObjectArray<btSolverBody>& bodies_;
  Of of_;
  std::vector<Row> rows_;
  bool gives_way_ = false;
};

}  // namespace genphys::bullet_backend

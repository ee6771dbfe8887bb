#pragma once
#include <BulletDynamics/MLCPSolvers/btDantzigLCP.h>

#include <vector>

#include "genphys/bounded_solver.h"

namespace genphys::bullet_backend {

/// Bullet's solver of complementarity problems by Dantzig's pivoting. It remembers nothing from one solve to the next.
class DantzigSolver final : public BoundedSolver {
 public:
  bool Solve(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& wanted, std::span<const Bounds> bounds,
             Eigen::VectorXd& impulses) override;

 private:
  // Bullet works in these.
  Eigen::MatrixXd matrix_;
  Eigen::VectorXd wanted_;
  Eigen::VectorXd rates_;
  std::vector<double> lower_;
  std::vector<double> upper_;
  std::vector<int> bounded_by_;
  btDantzigScratchMemory memory_;
};

}  // namespace genphys::bullet_backend

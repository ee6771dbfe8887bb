#include "dantzig_solver.h"

#include <mutex>

namespace genphys::bullet_backend {
namespace {

// Bullet notes in a variable of the process that a solve has failed: another one beside it would take that for its own.
std::mutex library;

}  // namespace

bool DantzigSolver::Solve(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& wanted, std::span<const Bounds> bounds,
                          Eigen::VectorXd& impulses) {
  const auto size = static_cast<int>(wanted.size());
  matrix_ = matrix;
  wanted_ = wanted;
  rates_.setZero(size);
  impulses.setZero(size);
  lower_.clear();
  upper_.clear();
  bounded_by_.clear();
  for (const Bounds& each : bounds) {
    lower_.push_back(each.lower);
    upper_.push_back(each.upper);
    bounded_by_.push_back(each.bounded_by);
  }
  const std::lock_guard lock(library);
  // None is without bounds.
  return btSolveDantzigLCP(size, matrix_.data(), impulses.data(), wanted_.data(), rates_.data(), 0, lower_.data(),
                           upper_.data(), bounded_by_.data(), memory_) &&
         impulses.allFinite();
}

}  // namespace genphys::bullet_backend

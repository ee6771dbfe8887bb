#include "contacts/disc_solve.h"

#include <algorithm>
#include <cmath>

namespace genphys {
namespace {

using Bounds = BoundedSolver::Bounds;

// What rests does so by what it was started from, and then fewer suffice.
constexpr int kSweepsMax = 20;
// m/s or rad/s: sweeps end once nothing changes by more, or by more than this part of what impulses do by themselves,
// which is where something heavy lies on something light much more than all of them do together.
constexpr double kSettled = 1e-13;
constexpr double kRounding = 1e-14;
// Most directions are right after three solves. What changes who slips and who holds takes some more.
constexpr int kTurnsMax = 12;
// m/s or rad/s: friction that is no further from Coulomb's law is left.
constexpr double kAgreed = 1e-10;

bool Sweep(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& wanted, std::span<const Bounds> bounds,
           Eigen::VectorXd& impulses) {
  const auto is_settled_after_sweep = [&] {
    double largest = 0, strongest = 0;
    for (Eigen::Index i = 0; i < impulses.size(); ++i) {
      const auto& [lower, upper, bounded_by] = bounds[static_cast<size_t>(i)];
      const double scale = bounded_by == BoundedSolver::kFree ? 1 : std::abs(impulses[bounded_by]);
      const double lacking = wanted[i] - matrix.col(i).dot(impulses);
      const double impulse = std::clamp(impulses[i] + lacking / matrix(i, i), scale * lower, scale * upper);
      largest = std::max(largest, std::abs(impulse - impulses[i]) * matrix(i, i));
      strongest = std::max(strongest, std::abs(impulse) * matrix(i, i));
      impulses[i] = impulse;
    }
    return largest <= std::max(kSettled, kRounding * strongest);
  };
  for (int i = 0; i < kSweepsMax; ++i) {
    if (is_settled_after_sweep()) return true;
  }
  return false;
}

}  // namespace

DiscSolve::DiscSolve(BoundedSolver& solver, const Eigen::MatrixXd& matrix, const Eigen::VectorXd& wanted,
                     std::span<const Bounds> bounds, std::span<const Eigen::Index> pairs)
    : solver_(solver), matrix_(matrix), wanted_(wanted), bounds_(bounds) {
  auto pair = pairs.begin();
  for (Eigen::Index row = 0; row < wanted.size(); ++row) {
    if (bounds[static_cast<size_t>(row)].bounded_by == BoundedSolver::kFree) continue;
    const bool is_pair = pair != pairs.end() && *pair == row;
    frictions_.push_back({row, is_pair, {}});
    if (!is_pair) continue;
    ++pair;
    ++row;
  }
}

bool DiscSolve::Run(Eigen::VectorXd& impulses) {
  if (!Sweep(matrix_, wanted_, bounds_, impulses) && !solver_.Solve(matrix_, wanted_, bounds_, impulses)) return false;
  if (frictions_.empty()) return true;
  Eigen::VectorXd next = impulses;
  double least = Follow(next);
  for (int i = 0; least > kAgreed && i < kTurnsMax && SolveTurned(next); ++i) {
    const double off = Follow(next);
    if (off >= least) continue;
    least = off;
    impulses = next;
  }
  return true;
}

double DiscSolve::Follow(const Eigen::VectorXd& impulses) {
  const Eigen::VectorXd slips = matrix_ * impulses - wanted_;
  double worst = 0;
  for (auto& [row, is_pair, disc] : frictions_) {
    const Bounds& bounds = bounds_[static_cast<size_t>(row)];
    const double most = bounds.upper * impulses[bounds.bounded_by];
    double mobility = matrix_(row, row);
    Eigen::Vector2d impulse(impulses[row], 0), slip(slips[row], 0);
    if (is_pair) {
      mobility = (mobility + matrix_(row + 1, row + 1)) / 2;
      impulse.y() = impulses[row + 1];
      slip.y() = slips[row + 1];
    }
    worst = std::max(worst, disc.Follow(impulse, slip, mobility, most));
  }
  return worst;
}

void DiscSolve::Turn(bool back, Eigen::VectorXd& vector) const {
  for (const auto& [row, is_pair, disc] : frictions_) {
    if (!is_pair) continue;
    const double x = disc.along().x(), y = back ? -disc.along().y() : disc.along().y();
    const double first = vector[row], second = vector[row + 1];
    vector[row] = x * first + y * second;
    vector[row + 1] = x * second - y * first;
  }
}

bool DiscSolve::SolveTurned(Eigen::VectorXd& impulses) const {
  Eigen::MatrixXd matrix = matrix_;
  Eigen::VectorXd wanted = wanted_;
  // The engine takes what presses for the bounds of friction as it is without any.
  std::vector<Bounds> known(bounds_.begin(), bounds_.end());
  for (const auto& [row, is_pair, disc] : frictions_) {
    const double most = disc.most();
    known[static_cast<size_t>(row)] = {-most, most};
    if (!is_pair) continue;
    known[static_cast<size_t>(row) + 1] = {-most, most};
    const double x = disc.along().x(), y = disc.along().y();
    const Eigen::Matrix2d turn{{x, y}, {-y, x}};
    matrix.middleRows<2>(row) = (turn * matrix.middleRows<2>(row)).eval();
    matrix.middleCols<2>(row) = (matrix.middleCols<2>(row) * turn.transpose()).eval();
    matrix(row + 1, row + 1) += disc.softness();
  }
  Turn(false, wanted);
  Turn(false, impulses);
  if (!Sweep(matrix, wanted, bounds_, impulses) && !solver_.Solve(matrix, wanted, known, impulses)) return false;
  Turn(true, impulses);
  return true;
}

}  // namespace genphys

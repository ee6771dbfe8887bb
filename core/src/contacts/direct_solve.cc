#include "contacts/direct_solve.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numeric>

#include "contacts/disc_solve.h"

namespace genphys {
namespace {

// m/s or rad/s: where softness leaves more than this of a row, it takes an impulse that nothing real has, as where what
// commands move jams against what joints hold. Numbers do not suffice for such impulses.
constexpr double kJam = 1e-2;

}  // namespace

void DirectSolve::Add(const SolverRow& row, double wanted, const Bounds& bounds, double softness, double slack,
                      double& impulse, double foretold) {
  Row added;
  added.impulse = &impulse;
  added.foretold = foretold;
  added.bounds = bounds;
  added.wanted = wanted / row.inverse;
  added.a = {row.a, row.push, row.turn_a, row.push * changes_[row.a].inverse_mass, row.gain_a};
  added.b = {row.b, -row.push, row.turn_b, -row.push * changes_[row.b].inverse_mass, row.gain_b};
  added.slack = slack * (Dot(added.a, added.a) + Dot(added.b, added.b));
  added.softness = softness + added.slack;
  rows_.push_back(added);
}

double DirectSolve::Dot(const Part& x, const Part& y) { return x.body == y.body ? x.Answer(y) : 0; }

Eigen::MatrixXd DirectSolve::Matrix(const std::vector<size_t>& of, const std::vector<size_t>& by) const {
  Eigen::MatrixXd matrix(of.size(), by.size());
  for (size_t i = 0; i < of.size(); ++i) {
    const Row& x = rows_[of[i]];
    for (size_t j = 0; j < by.size(); ++j) {
      const Row& y = rows_[by[j]];
      matrix(i, j) = Dot(x.a, y.a) + Dot(x.a, y.b) + Dot(x.b, y.a) + Dot(x.b, y.b);
      if (of[i] == by[j]) matrix(i, j) += x.softness;
    }
  }
  return matrix;
}

Eigen::VectorXd DirectSolve::Wanted(const std::vector<size_t>& of) const {
  Eigen::VectorXd wanted(of.size());
  for (size_t i = 0; i < of.size(); ++i) wanted[i] = rows_[of[i]].wanted;
  return wanted;
}

bool DirectSolve::SolveBounded(BoundedSolver& solver, const Eigen::MatrixXd& matrix, const Eigen::VectorXd& wanted,
                               const std::vector<size_t>& bounded, Eigen::VectorXd& impulses) const {
  std::vector<int> place(rows_.size());
  for (size_t i = 0; i < bounded.size(); ++i) place[bounded[i]] = static_cast<int>(i);
  std::vector<Bounds> bounds;
  std::vector<Eigen::Index> pairs;
  for (const size_t number : bounded) {
    Bounds& added = bounds.emplace_back(rows_[number].bounds);
    if (added.bounded_by != BoundedSolver::kFree) added.bounded_by = place[static_cast<size_t>(added.bounded_by)];
    if (rows_[number].is_first_of_two) pairs.push_back(place[number]);
  }
  return DiscSolve(solver, matrix, wanted, bounds, pairs).Run(impulses);
}

bool DirectSolve::IsJammed(const std::vector<size_t>& rows, const Eigen::VectorXd& impulses) const {
  for (size_t i = 0; i < rows.size(); ++i) {
    if (rows_[rows[i]].slack * std::abs(impulses[static_cast<Eigen::Index>(i)]) > kJam) return true;
  }
  return false;
}

void DirectSolve::Apply(const std::vector<size_t>& rows, const Eigen::VectorXd& impulses) {
  for (size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows_[rows[i]];
    const double impulse = impulses[static_cast<Eigen::Index>(i)];
    const double change = impulse - *row.impulse;
    *row.impulse = impulse;
    for (const Part* part : {&row.a, &row.b}) {
      MotionChange& body = changes_[part->body];
      body.linear += change * part->linear_gain;
      body.angular += change * part->angular_gain;
    }
  }
}

bool DirectSolve::Run(BoundedSolver* bounded) {
  return RunByLaws() || (bounded != nullptr && RunByElimination(*bounded));
}

bool DirectSolve::RunByLaws() {
  if (!laws_.Begin(rows_, changes_)) return false;
  Eigen::VectorXd impulses(rows_.size());
  for (size_t i = 0; i < rows_.size(); ++i) impulses[i] = rows_[i].foretold;
  if (!laws_.Run(impulses)) return false;
  std::vector<size_t> all(rows_.size());
  std::iota(all.begin(), all.end(), size_t{0});
  if (IsJammed(all, impulses)) return false;
  Apply(all, impulses);
  return true;
}

bool DirectSolve::RunByElimination(BoundedSolver& solver) {
  std::vector<size_t> free, bounded;
  for (size_t i = 0; i < rows_.size(); ++i) {
    const auto& [lower, upper, bounded_by] = rows_[i].bounds;
    const bool is_free = bounded_by == BoundedSolver::kFree && std::isinf(lower) && std::isinf(upper);
    (is_free ? free : bounded).push_back(i);
  }
  const Eigen::MatrixXd coupling = Matrix(free, bounded);
  // What the free rows do by themselves, and what they answer to each impulse of the others. Eigen looks at the first
  // element of what it solves for, so there has to be one.
  Eigen::VectorXd alone(free.size());
  Eigen::MatrixXd answer(free.size(), bounded.size());
  if (!free.empty()) {
    const Eigen::LDLT<Eigen::MatrixXd> factored(Matrix(free, free));
    alone = factored.solve(Wanted(free));
    if (!bounded.empty()) answer = factored.solve(coupling);
  }
  Eigen::VectorXd impulses(bounded.size());
  for (size_t i = 0; i < bounded.size(); ++i) impulses[i] = *rows_[bounded[i]].impulse;
  if (!SolveBounded(solver, Matrix(bounded, bounded) - coupling.transpose() * answer,
                    Wanted(bounded) - coupling.transpose() * alone, bounded, impulses)) {
    return false;
  }
  const Eigen::VectorXd answered = alone - answer * impulses;
  if (!answered.allFinite() || !impulses.allFinite()) return false;
  if (IsJammed(bounded, impulses)) return false;
  Apply(free, answered);
  Apply(bounded, impulses);
  return true;
}

}  // namespace genphys

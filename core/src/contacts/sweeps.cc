#include "contacts/sweeps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "genphys/work_watch.h"

namespace genphys {
namespace {

constexpr uint32_t kIterationsMax = 100;
// Where no more than one point in so many is still stirred after a preset's iterations, these get some more, for
// kPointUpdates in all. To look at so many others costs as much as one turn.
constexpr size_t kStillStirred = 4;
constexpr size_t kLooksPerTurn = 8;
// Softness of a contact that is solved all at once, of its own mobility: the solver divides by what redundant contacts
// leave over.
constexpr double kDirectSoftness = 1e-7;
// m/s, as kSettled: what only goes on like that for ever is left.
constexpr double kNearlySettled = 1e-8;
// m: in a pile, a sweep that pushes something no further than this out of an overlap has left it where it was. What
// rests lies that deep from step to step. With a tenth of it 1,000 boxes in a pile take a fifth longer to overlap no
// less.
constexpr double kLeastPush = 1e-5;

// Where joints and contacts press against each other, and neither gives way, each sweep presses harder, and each solve
// would begin with all of that, which lasts when they let go. Where joints hold a body this part of it is remembered.
constexpr double kStuckPart = 0.5;

// Of a WorkWatch.
constexpr size_t kRowWork = 2;

// Visits 0..count-1, of many points one of each half in turns: rows that follow each other mostly share a body, and
// each of them would have to wait for what the one before it made of that. (A row takes 7 ns instead of 9.5.) Sweeps
// come nearer in the order of the pairs, and few points stay in it, or go `back` in it.
template <typename Visit>
void VisitPoints(size_t count, bool back, Visit visit) {
  if (count <= ContactSweeps::kFewPoints) {
    for (size_t i = 0; i < count; ++i) visit(back ? count - 1 - i : i);
    return;
  }
  const size_t half = (count + 1) / 2;
  for (size_t i = 0; i < half; ++i) {
    visit(i);
    if (half + i < count) visit(half + i);
  }
}

// Whether the sweep goes back from the last point to the first, as every second one does once a preset's iterations
// did not suffice. In one direction what happens at the one end of a tower comes to the other end in one sweep, but
// back only by a point in each: 15 flat boxes swayed until they stood half a metre beside each other.
bool GoesBack(uint32_t sweep) { return sweep > ContactSweeps::kPresetIterations && sweep % 2 == 0; }

}  // namespace

void ContactSweeps::Impl::Begin(double step_size, double pull, bool are_few) {
  step_size_ = step_size;
  pull_ = pull;
  // Fewer iterations than a preset's do not find what all the more rows come to.
  are_few_ = are_few && iterations_ >= kPresetIterations;
  bodies_.assign(1, SweptBody{});
  rows_.clear();
  pairs_.clear();
  points_.clear();
  normals_.clear();
  frictions_.clear();
  pushes_.clear();
  joints_.clear();
  torsions_.clear();
  point_count_ = 0;
  is_stuck_.clear();
}

uint32_t ContactSweeps::Impl::AddBody(const SweptBody& body) {
  bodies_.push_back(body);
  return static_cast<uint32_t>(bodies_.size()) - 1;
}

void ContactSweeps::Impl::AddRow(uint32_t a, uint32_t b, JointRow& row) {
  rows_.push_back({a, b, &row});
  if (!row.is_stuck) return;
  is_stuck_.resize(bodies_.size());
  for (const uint32_t body : {a, b}) is_stuck_[body] = body != ContactSweeps::kFixed;
}

void ContactSweeps::Impl::AddPair(const AddedPair& pair) {
  pairs_.push_back(pair);
  point_count_ += pair.points.size();
}

void ContactSweeps::Impl::Solve() {
  WriteRows(false);
  PushApart();
  Sweep();
  TakeAll();
}

bool ContactSweeps::Impl::SolveDirectly(BoundedSolver* bounded, bool may_sweep) {
  WriteRows(true);
  const bool is_solved = FindVelocities(bounded);
  if (!is_solved && !may_sweep) return false;
  if (!PushDirectly(bounded, kLeastPush / step_size_)) PushApart();
  if (!is_solved) Sweep();
  TakeAll();
  return true;
}

void ContactSweeps::Impl::TakeAll() {
  for (size_t i = 0; i < rows_.size(); ++i) rows_[i].row->impulse = joints_[i].impulse;
  TakeImpulses();
  TakeMotions();
}

uint32_t ContactSweeps::Impl::Iterations() const {
  if (!may_go_on_) return iterations_;
  const size_t affordable = kPointUpdates / (1 + rows_.size() + point_count_);
  return std::max(iterations_, static_cast<uint32_t>(std::min<size_t>(affordable, kIterationsMax)));
}

void ContactSweeps::Impl::Sweep() {
  stirred_.Begin(changes_, kSettled);
  if (are_few_) leaps_.Begin(normals_.size() + frictions_.size() + torsions_.size());
  const uint32_t iterations = Iterations();
  const size_t all = joints_.size() + normals_.size();
  size_t spare = may_go_on_ ? kPointUpdates : 0;
  for (uint32_t sweep = 1;; ++sweep) {
    WorkWatch::Spend(static_cast<int64_t>(kRowWork * (all + frictions_.size())));
    const double residual = SweepOnce(sweep);
    if (residual <= kSettled) return;
    if (sweep >= iterations) {
      const size_t work = turns_ + all / kLooksPerTurn;
      if (sweep >= kIterationsMax || kStillStirred * turns_ > all || work > spare) return;
      spare -= work;
    }
    // Of sweeps there and back only those that end alike are compared.
    if (sweep == kPresetIterations) leaps_.Forget();
    const bool is_alike = sweep < kPresetIterations || GoesBack(sweep);
    const bool may_leap = are_few_ && is_alike && sweep + Leaps::kSweepsBetween <= iterations;
    if (may_leap && !Leap() && residual <= kNearlySettled) return;
  }
}

double ContactSweeps::Impl::SweepOnce(uint32_t sweep) {
  double largest = 0;
  stirred_.BeginSweep();
  turns_ = joints_.size();
  for (BoundedRow& row : joints_) {
    const double wanted = row.wanted - row.softness * row.inverse * row.impulse;
    largest = std::max(largest, Resolve(row, wanted, row.lower, row.upper));
  }
  VisitPoints(normals_.size(), GoesBack(sweep), [&](size_t i) {
    SolverRow& row = normals_[i];
    if (!stirred_.IsTurnOf(row.a, row.b)) return;
    ++turns_;
    largest = std::max(largest, Resolve(row, row.wanted, 0, std::numeric_limits<double>::infinity()));
  });
  VisitPoints(points_.size(), GoesBack(sweep),
              [&](size_t i) { largest = std::max(largest, SweepFriction(points_[i], normals_[i])); });
  return std::max(largest, SweepTorsions());
}

[[gnu::always_inline]] inline double ContactSweeps::Impl::SweepFriction(const AddedPoint& point,
                                                                        const SolverRow& normal) {
  if (!stirred_.IsTurnOf(normal.a, normal.b) || point.first_friction == point.end_friction) return 0;
  SolverRow& first = frictions_[point.first_friction];
  const double bound = first.friction * normal.impulse;
  if (point.end_friction - point.first_friction == 1) {
    // One that does not press has what it was started from taken out, and then nothing more.
    return bound != 0 || first.impulse != 0 ? Resolve(first, first.wanted, -bound, bound) : 0;
  }
  SolverRow& second = frictions_[point.first_friction + 1];
  if (bound == 0 && first.impulse == 0 && second.impulse == 0) return 0;
  return ResolveInDisc(first, second, bound);
}

double ContactSweeps::Impl::SweepTorsions() {
  double largest = 0;
  for (size_t i = 0; i < torsions_.size(); i += torsions_[i].is_first_of_two ? 2 : 1) {
    Torsion& row = torsions_[i];
    const SolverRow& normal = normals_[row.normal];
    if (!stirred_.IsTurnOf(normal.a, normal.b)) continue;
    const double most = row.arm * normal.impulse;
    const double change =
        row.is_first_of_two ? ResolveInDisc(row, torsions_[i + 1], most) : Resolve(row, row.wanted, -most, most);
    largest = std::max(largest, change);
  }
  return largest;
}

void ContactSweeps::Impl::PushApart() {
  const bool is_small = point_count_ <= kFewPoints;
  const double settled = is_small ? kSettled : kLeastPush / step_size_;
  // Of few none is passed over, or a stack would stand elsewhere by what rounding makes of its depths far away.
  pushed_.Begin(moves_, is_small ? 0 : settled);
  const uint32_t iterations = Iterations();
  for (uint32_t sweep = 0; sweep < iterations; ++sweep) {
    WorkWatch::Spend(static_cast<int64_t>(kRowWork * pushes_.size()));
    double largest = 0;
    pushed_.BeginSweep();
    for (ContactPush& push : pushes_) {
      const SolverRow& row = normals_[push.row];
      if (!pushed_.IsTurnOf(row.a, row.b)) continue;
      const double change = Relax(row, push.wanted, 0, std::numeric_limits<double>::infinity(), push.impulse,
                                  moves_[row.a], moves_[row.b]);
      pushed_.Note(row.a, row.b, change);
      largest = std::max(largest, std::abs(change));
    }
    if (largest <= settled) return;
  }
}

bool ContactSweeps::Impl::FindVelocities(BoundedSolver* bounded) {
  DirectSolve& solve = direct_;
  solve.Begin(changes_);
  const auto add = [&](SolverRow& row, const DirectSolve::Bounds& bounds) {
    solve.Add(row, row.wanted, bounds, 0, kDirectSoftness, row.impulse, row.impulse);
  };
  for (size_t i = 0; i < joints_.size(); ++i) {
    BoundedRow& row = joints_[i];
    solve.Add(row, row.wanted, {row.lower, row.upper}, row.softness, 0, row.impulse, rows_[i].row->impulse);
  }
  const int first_contact = static_cast<int>(joints_.size());
  for (SolverRow& row : normals_) add(row, {0, std::numeric_limits<double>::infinity()});
  for (size_t i = 0; i < points_.size(); ++i) {
    for (uint32_t j = points_[i].first_friction; j < points_[i].end_friction; ++j) {
      SolverRow& row = frictions_[j];
      add(row, {-row.friction, row.friction, first_contact + static_cast<int>(i)});
      if (j + 2 == points_[i].end_friction) solve.PairLast();
    }
  }
  for (Torsion& row : torsions_) {
    add(row, {-row.arm, row.arm, first_contact + static_cast<int>(row.normal)});
    if (row.is_first_of_two) solve.PairLast();
  }
  return solve.Run(bounded);
}

bool ContactSweeps::Impl::PushDirectly(BoundedSolver* bounded, double settled) {
  DirectSolve& solve = direct_;
  solve.Begin(moves_);
  double largest = 0;
  for (ContactPush& push : pushes_) {
    const SolverRow& row = normals_[push.row];
    solve.Add(row, push.wanted, {0, std::numeric_limits<double>::infinity()}, 0, kDirectSoftness, push.impulse,
              push.impulse);
    largest = std::max(largest, push.wanted * row.mobility);
  }
  if (largest <= settled) return true;
  // What joints lock stays together: what is opened here would be taken back as velocities, from step to step anew.
  for (BoundedRow& row : joints_) {
    if (std::isinf(row.lower) && std::isinf(row.upper)) {
      solve.Add(row, 0, {row.lower, row.upper}, row.softness, 0, row.pushed, row.pushed);
    }
  }
  return solve.Run(bounded);
}

template <typename Visit>
void ContactSweeps::Impl::VisitRows(Visit visit) {
  for (size_t i = 0; i < points_.size(); ++i) {
    const AddedPoint& point = points_[i];
    visit(normals_[i], 0, std::numeric_limits<double>::infinity());
    for (uint32_t j = point.first_friction; j < point.end_friction; ++j) {
      SolverRow& row = frictions_[j];
      const double bound = row.friction * normals_[i].impulse;
      visit(row, -bound, bound);
    }
  }
  for (Torsion& row : torsions_) {
    const double bound = row.arm * normals_[row.normal].impulse;
    visit(row, -bound, bound);
  }
}

bool ContactSweeps::Impl::Leap() {
  leaps_.BeginSweep();
  VisitRows([&](const SolverRow& row, double, double) { leaps_.Note(row.impulse, row.mobility); });
  if (!leaps_.Decide()) return !leaps_.leads_nowhere();
  size_t number = 0;
  VisitRows([&](SolverRow& row, double lower, double upper) {
    const double before = row.impulse;
    row.impulse = std::clamp(before + leaps_.Of(number++), lower, upper);
    const double change = row.impulse - before;
    Apply(row, change, changes_[row.a], changes_[row.b]);
    stirred_.Note(row.a, row.b, change * row.mobility);
  });
  return true;
}

bool ContactSweeps::Impl::IsStuck(uint32_t a, uint32_t b) const {
  return std::ranges::any_of(std::array{a, b},
                             [&](uint32_t body) { return body < is_stuck_.size() && is_stuck_[body] != 0; });
}

void ContactSweeps::Impl::TakeImpulses() {
  for (size_t i = 0; i < points_.size(); ++i) {
    const AddedPoint& added = points_[i];
    Vector3 across = Vector3::Zero();
    for (uint32_t j = added.first_friction; j < added.end_friction; ++j) {
      const SolverRow& row = frictions_[j];
      across -= row.push.head<3>() * row.impulse;
    }
    added.point->normal_impulse = normals_[i].impulse;
    added.point->friction_impulse = across;
    const double kept = IsStuck(normals_[i].a, normals_[i].b) ? kStuckPart : 1;
    *added.impulse = {kept * normals_[i].impulse, kept * across, Vector3::Zero()};
  }
  for (const Torsion& row : torsions_) {
    points_[row.normal].impulse->torque += row.impulse * row.turn_b.head<3>();
  }
}

void ContactSweeps::Impl::TakeMotions() {
  for (size_t i = 0; i < bodies_.size(); ++i) {
    SweptBody& body = bodies_[i];
    body.linear_velocity += changes_[i].linear.head<3>();
    body.angular_velocity += changes_[i].angular.head<3>();
    body.push = moves_[i].linear.head<3>();
    body.turn = moves_[i].angular.head<3>();
  }
}

}  // namespace genphys

// What solves make of the rows of joints, island by island, and what the layer makes of what they give.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "joints/haste.h"
#include "joints/inertia_factor.h"
#include "joints/joint_step.h"
#include "joints/row_rate.h"

namespace genphys {
namespace {

// Each makes what was too light for the step heavier.
constexpr int kSurprisesMax = 3;
// A pull that is no more than so many times what was expected is none.
constexpr double kSurprise = kUnforeseenSwing / kResolvedSwing / 1.5;
// What was locked, and moved apart by this part of what a body gained, and more than it may by rounding: the body was
// jolted. m/s or rad/s.
constexpr double kJolt = 0.5;
constexpr double kLeastJolt = 1e-6;

}  // namespace

double JointStep::QuietTarget(const JointRow& row) {
  if (row.is_driven) return row.target;
  // A limit still ahead may be come to, which gives nothing either.
  if (row.lower == 0) return std::min(row.target, 0.0);
  if (row.upper == 0) return std::max(row.target, 0.0);
  return 0;
}

const JointBody& JointStep::BodyAt(EntityRow side) const {
  return bodies_[side == kWorldRow ? 0 : body_of_[Index(side)]];
}

// Calls visit(body, arm, force) for what a solve of these rows pulls movable bodies by.
template <typename Visit>
void JointStep::VisitPulls(std::span<const JointRow> rows, std::span<const uint32_t> mine, Visit&& visit) {
  for (size_t i = 0; i < mine.size();) {
    const JointRow& first = rows[mine[i]];
    Vector3 impulse = Vector3::Zero();
    const size_t end_of_block = i + first.block;
    for (; i < mine.size(); ++i) {
      const JointRow& row = rows[mine[i]];
      if (i >= end_of_block && (row.b != first.b || row.point != first.point)) break;
      if (row.kind == JointRow::Kind::kLinear) impulse += row.impulse * row.axis;
    }
    for (const auto& [side, sign] : {std::pair(first.a, -1.0), std::pair(first.b, 1.0)}) {
      if (side == kWorldRow) continue;
      JointBody& body = bodies_[body_of_[Index(side)]];
      if (body.is_movable()) visit(body, first.point - body.center, Vector3(sign / body.interval * impulse));
    }
  }
}

// Sees without a matrix that nobody is pulled harder than expected, or hard at all: no stiffness is larger than
// sqrt(2) times its arm and force.
bool JointStep::MayBeSurprised(std::span<const JointRow> rows, std::span<const uint32_t> mine, double h) {
  for (const uint32_t moved : solver_.moved()) bodies_[moved].pulled_most = 0;
  VisitPulls(rows, mine, [](JointBody& body, const Vector3& arm, const Vector3& force) {
    body.pulled_most += std::numbers::sqrt2 * std::sqrt(arm.squaredNorm() * force.squaredNorm());
  });
  return std::ranges::any_of(solver_.moved(), [&](uint32_t moved) {
    const JointBody& body = bodies_[moved];
    return !(body.pulled_most <= kSurprise * body.pulled) &&
           !(h * h * body.own_inverse.norm() * body.pulled_most <= kUnforeseenSwing * body.factor);
  });
}

// Whether bodies need more inertia under what a solve of these rows gave than it found: where a chain comes taut the
// last substep did not tell.
bool JointStep::IsSurprised(std::span<const JointRow> rows, std::span<const uint32_t> mine, double h) {
  if (!MayBeSurprised(rows, mine, h)) return false;
  for (const uint32_t moved : solver_.moved()) bodies_[moved].pull.setZero();
  VisitPulls(rows, mine,
             [](JointBody& body, const Vector3& arm, const Vector3& force) { body.pull += PullStiffness(arm, force); });
  bool is_surprised = false;
  for (const uint32_t moved : solver_.moved()) {
    JointBody& body = bodies_[moved];
    if (body.pull.norm() <= kSurprise * body.pulled) continue;
    const double swing = SwingOf(body.own_inverse, body.pull, h);
    if (!(swing > kUnforeseenSwing * body.factor)) continue;
    body.factor = InertiaFactor(swing);
    body.inverse_tensor = body.own_inverse / body.factor;
    is_surprised = true;
  }
  return is_surprised;
}

bool JointStep::SolveIsland(uint32_t island, double h, std::vector<JointRow>& rows) {
  const std::span<const uint32_t> mine = islands_.JointRowsOf(island);
  for (int surprises = 0;; ++surprises) {
    if (!solver_.Solve(island, rows, mine, body_of_, bodies())) return false;
    if (surprises == kSurprisesMax || !IsSurprised(rows, mine, h)) break;
    for (const uint32_t moved : solver_.moved()) bodies_[moved].Return();
  }
  const auto is_followed = [&] { return solver_.is_swept() || !IsResolved(mine, h) || Follow(island, h, rows); };
  // Aims that cannot be met: from where it began, as near as one solve comes to the last of them.
  const bool is_solved = TurnMotors(island, rows) && (is_followed() || SolveAnew(island, rows));
  for (const TurningMotor& motor : motors_) motor.Restore(rows[motor.row]);
  motors_.clear();
  return is_solved;
}

void JointStep::FindJolts(std::span<const JointRow> rows) {
  jolts_.assign(islands_.islands().size(), {});
  bool may_any_be = false;
  for (const JointBody& body : bodies()) {
    const uint32_t island = body.begins ? islands_.IslandOf(body.row) : Islands::kNone;
    if (island != Islands::kNone) may_any_be = jolts_[island].may_be = true;
  }
  if (!may_any_be) return;
  for (const JointRow& row : rows) {
    const uint32_t island = islands_.IslandOf(row.a, row.b);
    if (island == Islands::kNone || !jolts_[island].may_be || row.is_driven || row.lower == 0 || row.upper == 0)
      continue;
    const JointBody &a = BodyAt(row.a), &b = BodyAt(row.b);
    const double rate = RateOf(row, a, {a.linear_before, a.angular_before}, b, {b.linear_before, b.angular_before});
    Jolt& jolt = jolts_[island];
    double& most = row.kind == JointRow::Kind::kLinear ? jolt.linear : jolt.angular;
    most = std::max(most, std::abs(rate));
  }
}

bool JointStep::IsJolted(EntityRow row, const Vector3& gained, const Vector3& turned) const {
  const uint32_t island = jolts_.empty() ? Islands::kNone : islands_.IslandOf(row);
  if (island == Islands::kNone) return false;
  const Jolt& jolt = jolts_[island];
  return jolt.linear > std::max(kLeastJolt, kJolt * gained.norm()) ||
         jolt.angular > std::max(kLeastJolt, kJolt * turned.norm());
}

bool JointStep::SolveQuietly(uint32_t island, std::vector<JointRow>& rows) {
  if (island >= is_solved_.size() || !is_solved_[island]) return false;
  const std::span<const uint32_t> mine = islands_.JointRowsOf(island);
  targets_.clear();
  for (const uint32_t i : mine) {
    JointRow& row = rows[i];
    targets_.push_back(row.target);
    for (const EntityRow side : {row.a, row.b}) {
      if (side == kWorldRow) continue;
      JointBody& body = bodies_[body_of_[Index(side)]];
      if (!body.is_movable()) continue;
      body.factor = 1;
      body.inverse_tensor = body.own_inverse;
      body.Return();
    }
    row.target = QuietTarget(row);
  }
  const bool is_solved = solver_.Solve(island, rows, mine, body_of_, bodies());
  for (size_t i = 0; i < mine.size(); ++i) rows[mine[i]].target = targets_[i];
  return is_solved;
}

void JointStep::BoundWaits(double h, std::span<const JointRow> rows, std::span<SolveEnergy> energies) const {
  struct Errors {
    double wait = 0;  // m or rad per second of a substep
    double made = 0;
  };
  // By island, along and about.
  std::vector<std::array<Errors, 2>> errors(energies.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    const JointRow& row = rows[i];
    const uint32_t island = islands_.IslandOf(row.a, row.b);
    if (island == Islands::kNone || !energies[island].is_layers) continue;
    auto& [wait, made] = errors[island][row.kind == JointRow::Kind::kLinear ? 0 : 1];
    wait = std::max(wait, std::abs(row.target - QuietTarget(row)));
    made = std::max(made, BendAt(rows, i, h));
  }
  for (size_t island = 0; island < errors.size(); ++island) {
    for (const auto& [wait, made] : errors[island]) {
      if (wait > made) energies[island].way = std::max(energies[island].way, 1 - made / wait);
    }
  }
}

std::span<JointRow> JointStep::Solve(Solver solver, double h, std::span<const EntityRow> moving,
                                     const ContactBuffer& contacts, std::vector<JointRow>& rows) {
  left_.clear();
  left_rows_.clear();
  gives_mean_.clear();
  if (rows.empty()) return rows;
  islands_.Find(state_.rows(), moving, contacts, rows);
  FindJolts(rows);
  is_solved_.assign(islands_.islands().size(), false);
  for (uint32_t i = 0; i < rows.size(); ++i) {
    if (solver == Solver::kIterative || islands_.IslandOf(rows[i].a, rows[i].b) == Islands::kNone) left_.push_back(i);
  }
  if (solver == Solver::kIterative) return rows;
  for (uint32_t island = 0; island < islands_.islands().size(); ++island) {
    const std::span<const uint32_t> mine = islands_.JointRowsOf(island);
    const bool touches_nothing = islands_.islands()[island].contacts == 0;
    if (mine.empty()) continue;
    is_solved_[island] = touches_nothing && SolveIsland(island, h, rows);
    if (is_solved_[island]) continue;
    left_.insert(left_.end(), mine.begin(), mine.end());
    if (!touches_nothing) continue;
    // Of solves before one that failed.
    for (const uint32_t i : mine) rows[i].impulse = 0;
  }
  gives_mean_.assign(islands_.islands().size(), false);
  for (JointBody& body : bodies()) {
    if (!body.is_movable()) continue;
    const uint32_t island = islands_.IslandOf(body.row);
    if (body.goes_on && island != Islands::kNone && is_solved_[island]) gives_mean_[island] = true;
    state_.linear_velocities.col(Index(body.row)) = body.linear_velocity;
    state_.angular_velocities.col(Index(body.row)) = body.is_followed ? body.flow : body.angular_velocity;
  }
  for (const JointBody& body : bodies()) {
    const uint32_t island = body.is_late && body.is_movable() ? islands_.IslandOf(body.row) : Islands::kNone;
    if (island != Islands::kNone) gives_mean_[island] = false;
  }
  if (left_.size() == rows.size()) return rows;
  std::sort(left_.begin(), left_.end());
  for (const uint32_t i : left_) left_rows_.push_back(rows[i]);
  return left_rows_;
}

void JointStep::TakeLeft(double h, std::vector<JointRow>& rows) {
  for (const JointBody& body : bodies()) {
    if (body.is_followed) state_.angular_velocities.col(Index(body.row)) = body.angular_velocity;
  }
  for (size_t i = 0; i < left_rows_.size(); ++i) rows[left_[i]].impulse = left_rows_[i].impulse;
  WatchHaste(h);
}

// Those that nothing is in the way of have it back sooner or later.
void JointStep::WatchHaste(double h) {
  HasteWatch watch(scene_, state_, islands_, bodies(), body_of_, rows_, h);
  for (size_t first = 0, end; first < owners_.size(); first = end) {
    for (end = first + 1; end < owners_.size() && owners_[end] == owners_[first];) ++end;
    double& haste = layer_.joints[held_[owners_[first]].slot].haste;
    if (left_.empty() && haste == 1) continue;
    const uint32_t island = islands_.IslandOf(rows_[first].a, rows_[first].b);
    if (island == Islands::kNone) continue;
    const auto own = std::span<const JointRow>(rows_).subspan(first, end - first);
    haste = is_solved_[island] ? HasteWatch::Recovered(haste) : watch.After(own, island, haste);
  }
}

void JointStep::AllowWork(double h, std::span<const JointRow> rows, std::span<SolveEnergy> energies) const {
  const auto mean_of = [&](const JointBody& body) -> Velocities {
    if (body.row == kWorldRow) return {};
    return {(body.linear_given + state_.linear_velocities.col(Index(body.row))) / 2,
            (body.angular_given + state_.angular_velocities.col(Index(body.row))) / 2};
  };
  for (size_t i = 0; i < rows.size(); ++i) {
    const JointRow& row = rows[i];
    const uint32_t island = islands_.IslandOf(row.a, row.b);
    if (island == Islands::kNone) continue;
    const auto is_another_point = [&] { return i == 0 || !BendsAlike(rows[i - 1], row); };
    if (jolts_[island].may_be && row.kind == JointRow::Kind::kLinear && is_another_point()) {
      energies[island].bend += BendAt(rows, i, h);
    }
    if (!row.is_driven) {
      energies[island].allowed += row.repair;
      continue;
    }
    // A force that does not change through the solve works along the mean of both rates.
    const JointBody &a = BodyAt(row.a), &b = BodyAt(row.b);
    const double rate = RateOf(row, a, mean_of(a), b, mean_of(b));
    energies[island].allowed += std::max(row.impulse * rate, 0.0);
  }
}

}  // namespace genphys

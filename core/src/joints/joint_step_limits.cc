// Limits that are reached in the course of a substep. A solve stops what comes to one where the limit is, by the end of
// the substep, which is right on the mean, and by a part of the blow only: it has come there before the end, was
// stopped and perhaps pulled away again.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "joints/joint_step.h"
#include "joints/kinds.h"
#include "joints/row_rate.h"
#include "motion/free_rotation.h"

namespace genphys {

void JointStep::FindReached(RowMarks& reached) {
  reached_.clear();
  for (const JointRow& row : rows_) {
    if (!row.is_reached || row.impulse == 0) continue;
    for (const EntityRow side : {row.a, row.b}) {
      if (BodyAt(side).is_movable() && !reached[side]) reached_.push_back(LinkedWith(side, reached));
    }
  }
}

std::vector<JointStep::Change> JointStep::LeaveReached(double h, PushOf push_of, std::vector<Led>& led) {
  std::vector<Change> changes;
  for (const Linked& group : reached_) {
    if (!FollowReached(group, h, push_of, led)) LeaveReached(group, h, changes);
  }
  return changes;
}

// Where the substep led it; its place is its row.
JointBody JointStep::EndOf(EntityRow side, size_t place) const {
  JointBody body = BodyNow(scene_, state_, side);
  if (side == kWorldRow) return body;
  const SceneEntity& entity = *scene_.entities[Index(side)];
  body.row = EntityRow{static_cast<uint32_t>(place)};
  if (!entity.traits.is_dynamic || !active_[Index(side)]) return body;
  body.inverse_mass = 1 / entity.mass.mass;
  body.own_inverse = body.inverse_tensor = WorldTensor(body.axes, entity.mass.inverse_tensor);
  return body;
}

// What the last solve made of the limit that this row of the same joint is of, or null.
const JointRow* JointStep::SolvedLimit(const Held& held, const JointRow& now) const {
  const JointRow* found = nullptr;
  const auto likeness = [&](const JointRow& row) { return std::abs(row.axis.dot(now.axis)); };
  const auto [first, last] = std::ranges::equal_range(owners_, static_cast<uint32_t>(&held - held_.data()));
  for (auto owner = first; owner != last; ++owner) {
    const JointRow& row = rows_[static_cast<size_t>(owner - owners_.begin())];
    if (!IsLimit(row) || row.kind != now.kind || row.upper != now.upper) continue;
    if (found == nullptr || likeness(row) > likeness(*found)) found = &row;
  }
  return found;
}

// The rows of a joint at the end of the substep, between bodies that move so there, and what they ask for of a change.
// Whether what a limit stopped is pressed against it from now on.
bool JointStep::WriteReached(const Held& held, const JointBody& body_a, const JointBody& body_b, double h,
                             std::vector<JointRow>& rows) const {
  bool is_pressed = false;
  for (JointRow& row : RowsBetween(held.slot, body_a, body_b, h)) {
    row.target = 0;
    if (!IsLocked(row)) {
      const JointRow* const solved = IsLimit(row) ? SolvedLimit(held, row) : nullptr;
      if (solved == nullptr || solved->impulse == 0) continue;
      if (solved->is_reached) {
        const double rate = RateOf(row, body_a, {body_a.linear_velocity, body_a.angular_velocity}, body_b,
                                   {body_b.linear_velocity, body_b.angular_velocity});
        row.target = (row.lower == 0 ? solved->leaving : -solved->leaving) - rate;
        is_pressed |= solved->leaving == 0;
      }
    }
    rows.push_back(row);
  }
  return is_pressed;
}

void JointStep::LeaveReached(const Linked& group, double h, std::vector<Change>& changes) {
  std::vector<EntityRow> sides{kWorldRow};
  std::vector<JointBody> bodies{1};
  const auto place_of = [&](EntityRow side) {
    const auto known = std::ranges::find(sides, side);
    const auto place = static_cast<size_t>(known - sides.begin());
    if (known == sides.end()) {
      sides.push_back(side);
      bodies.push_back(EndOf(side, place));
    }
    return place;
  };
  for (const EntityRow row : group.rows) place_of(row);
  std::vector<JointRow> rows;
  std::vector<Held*> owners;
  bool is_pressed = false;
  for (const uint32_t slot : group.slots) {
    const auto held = std::ranges::lower_bound(held_, slot, {}, &Held::slot);
    if (held == held_.end() || held->slot != slot) continue;
    const JointDesc& desc = scene_.joints[slot]->desc;
    const size_t a = place_of(RowOf(desc.entity_a)), b = place_of(RowOf(desc.entity_b));
    is_pressed |= WriteReached(*held, bodies[a], bodies[b], h, rows);
    owners.resize(rows.size(), &*held);
  }
  WriteLocks(group, bodies, rows);
  for (JointBody& body : bodies) {
    body.linear_velocity.setZero();
    body.angular_velocity.setZero();
  }
  std::vector<uint32_t> mine(rows.size()), body_of(bodies.size());
  std::iota(mine.begin(), mine.end(), 0);
  std::iota(body_of.begin(), body_of.end(), 0);
  RowSolver solver;
  if (!solver.Solve(0, rows, mine, body_of, bodies) || solver.is_swept()) return;
  for (size_t i = 0; i < owners.size(); ++i) owners[i]->Bear(1, rows[i]);
  for (size_t i = 0; i < group.rows.size(); ++i) {
    const JointBody& body = bodies[i + 1];
    changes.push_back({group.rows[i], body.linear_velocity, body.angular_velocity, is_pressed});
  }
}

}  // namespace genphys

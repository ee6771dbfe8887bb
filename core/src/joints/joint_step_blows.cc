// What joints do in a blow, which is over before a step goes on.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "joints/joint_step.h"
#include "joints/kinds.h"
#include "joints/row_rate.h"
#include "motion/locked_axes.h"

namespace genphys {
namespace {

void SortOnce(std::vector<uint32_t>& slots) {
  std::ranges::sort(slots);
  const auto twice = std::ranges::unique(slots);
  slots.erase(twice.begin(), twice.end());
}

// Of what a solve gave as the mean of what joints gave until the boundary and give since, the part of drives: each says
// itself what it gives since.
class DrivesSince {
 public:
  void Take(double share, const JointRow& row) {
    if (row.since < 0) return;
    change_ += (row.since - 1) * share * row.impulse * row.axis;
    const Vector3 axis = beside_ * row.axis;
    // What lies between the others' axes but for rounding is none of its own.
    if (axis.squaredNorm() > kBetween) beside_ -= axis * axis.transpose() / axis.squaredNorm();
  }
  // By how much more than that `mean` is what all give since, if they gave `before` until then.
  Vector3 More(const Vector3& mean, const Vector3& before) const { return beside_ * (mean - before) + change_; }

 private:
  static constexpr double kBetween = 1e-12;

  Matrix3 beside_ = Matrix3::Identity();  // takes from a vector what is along axes of such drives
  Vector3 change_ = Vector3::Zero();      // N*s or N*m*s
};

// Of what a joint gave along the row of a motor to a speed, which nothing else did: what it cannot have given.
Vector3 BeyondBound(double share, const JointRow& row, std::span<const JointRow> rows, const Vector3& given) {
  if (!row.is_driven || row.since >= 0 || !std::isfinite(row.upper)) return Vector3::Zero();
  const auto gives_as_well = [&](const JointRow& other) {
    return &other != &row && other.kind == row.kind && other.axis == row.axis && other.impulse != 0;
  };
  if (std::ranges::any_of(rows, gives_as_well)) return Vector3::Zero();
  const double along = row.axis.dot(given), most = share * row.upper;
  return (along - std::clamp(along, -most, most)) * row.axis;
}

}  // namespace

template <typename IsLoose>
JointStep::Linked JointStep::LinkedWith(EntityRow row, RowMarks& seen, IsLoose&& is_loose) const {
  Linked linked{.rows = {row}, .slots = {}, .loose = {}};
  seen.Mark(row);
  const auto is_new = [&](EntityRow side) {
    if (side == kWorldRow || !active_[Index(side)] || seen[side]) return false;
    return scene_.entities[Index(side)]->traits.is_dynamic;
  };
  for (size_t i = 0; i < linked.rows.size(); ++i) {
    for (const uint32_t slot : index_.Of(linked.rows[i])) {
      const JointDesc& desc = scene_.joints[slot]->desc;
      if (!MayHold(desc)) continue;
      if (is_loose(slot)) {
        linked.loose.push_back(slot);
        continue;
      }
      linked.slots.push_back(slot);
      for (const EntityRow side : {RowOf(desc.entity_a), RowOf(desc.entity_b)}) {
        if (!is_new(side)) continue;
        seen.Mark(side);
        linked.rows.push_back(side);
      }
    }
  }
  SortOnce(linked.slots);
  SortOnce(linked.loose);
  return linked;
}

JointStep::Linked JointStep::LinkedWith(EntityRow row, RowMarks& seen) const {
  return LinkedWith(row, seen, [](uint32_t) { return false; });
}

JointStep::Linked JointStep::TiedTo(EntityRow row, RowMarks& seen) const {
  return LinkedWith(row, seen, [&](uint32_t slot) { return !LocksAny(scene_.joints[slot]->desc.kind); });
}

std::vector<JointRow> JointStep::RowsBetween(uint32_t slot, const JointBody& a, const JointBody& b, double h) const {
  const JointDesc& desc = scene_.joints[slot]->desc;
  const JointSide side_a = JointSide::Now(a, *desc.frame_in_a), side_b = JointSide::Now(b, *desc.frame_in_b);
  JointState state = layer_.joints[slot];
  std::vector<JointRow> rows;
  RowWriter writer(side_a, side_b, h, {}, state, &rows, {});
  std::visit([&](const auto& joint) { WriteRows(joint, writer); }, desc.kind);
  return rows;
}

void JointStep::WriteLocked(uint32_t slot, const JointBody& a, const JointBody& b, std::vector<JointRow>& rows) const {
  // How fast errors are made up for does not matter here.
  std::ranges::copy_if(RowsBetween(slot, a, b, layer_.last_substep), std::back_inserter(rows), IsLocked);
}

void JointStep::WriteLocks(const Linked& linked, std::span<const JointBody> bodies, std::vector<JointRow>& rows) const {
  for (size_t i = 0; i < linked.rows.size(); ++i) {
    const SceneEntity& entity = *scene_.entities[Index(linked.rows[i])];
    const LockedAxes& locks = entity.desc->rigid_body->locked_axes;
    const JointBody& body = bodies[i + 1];
    if (locks.any()) genphys::WriteLocks(locks, entity.mass, body.row, body.center, body.pose.orientation, rows);
  }
}

std::vector<JointRow> JointStep::LooseRows(uint32_t slot) const {
  const auto held = std::ranges::find(held_, slot, &Held::slot);
  if (held == held_.end()) return {};
  std::vector<JointRow> loose;
  const auto [first, last] = std::ranges::equal_range(owners_, static_cast<uint32_t>(held - held_.begin()));
  for (auto owner = first; owner != last; ++owner) {
    const JointRow& row = rows_[static_cast<size_t>(owner - owners_.begin())];
    // What drives as it was told before does so until the boundary.
    if (IsLocked(row) || row.is_reached || row.since == 0) continue;
    const double part = row.since > 0 ? held->share * row.since : held->share;
    JointRow& each = loose.emplace_back(row);
    for (double* const value : {&each.impulse, &each.lower, &each.upper}) *value *= part;
  }
  return loose;
}

void JointStep::Held::BeginSubstep() {
  last_force.setZero();
  force_begun = force;
  torque_begun = torque;
}

void JointStep::Held::BearSince(double h, std::span<const JointRow> rows) {
  DrivesSince along, about;
  for (const JointRow& row : rows) (row.kind == JointRow::Kind::kLinear ? along : about).Take(share, row);
  force += along.More(force - force_begun, h * before.force);
  torque += about.More(torque - torque_begun, h * before.torque);
  // A motor that came to push with all it may gave less than that on the mean.
  for (const JointRow& row : rows) {
    const bool is_linear = row.kind == JointRow::Kind::kLinear;
    const Vector3 given = is_linear ? Vector3(force - force_begun) : Vector3(torque - torque_begun);
    (is_linear ? force : torque) -= BeyondBound(share, row, rows, given);
  }
}

void JointStep::Held::Bear(double part, const JointRow& row) {
  switch (row.kind) {
    case JointRow::Kind::kLinear:
      force += part * row.impulse * row.axis;
      break;
    case JointRow::Kind::kAngular:
      torque += part * row.impulse * row.axis;
      break;
    case JointRow::Kind::kGeared:
      torque += part * row.impulse * row.axis_b;
      break;
  }
}

void JointStep::Bear(uint32_t slot, const JointRow& row) {
  SortHeld();
  const auto held = std::ranges::lower_bound(held_, slot, {}, &Held::slot);
  if (held == held_.end() || held->slot != slot) return;
  held->Bear(1, row);
  held->was_held = true;
}

}  // namespace genphys

// What joints do in a blow, which is over before a step goes on.
#include <algorithm>
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
    if (IsLocked(row) || row.is_reached) continue;
    loose.push_back(row);
    loose.back().impulse *= held->share;
  }
  return loose;
}

void JointStep::Held::BeginSubstep() {
  last_force.setZero();
  force_begun = force;
  torque_begun = torque;
}

void JointStep::Held::BearSince(double h) {
  force += force - force_begun - h * before.force;
  torque += torque - torque_begun - h * before.torque;
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

#include "joint_step.h"

#include <algorithm>

#include "free_rotation.h"
#include "joints/kinds.h"

namespace genphys {

JointSide JointStep::SideOf(const EntityRef& entity, const Pose& frame, double h) const {
  JointSide side;
  side.row = RowOf(entity);
  side.frame = frame;
  if (side.row == kWorldRow) return side;
  const uint32_t row = Index(side.row);
  const SceneEntity& scene_entity = *scene_.entities[row];
  const Pose pose = state_.pose(side.row);
  side.frame = pose.Transform(frame);
  side.center = pose.position;
  side.linear_velocity = state_.linear_velocities.col(row);
  side.angular_velocity = state_.angular_velocities.col(row);
  const auto& body = scene_entity.desc->rigid_body;
  side.linear_expected = side.linear_velocity;
  side.angular_expected = side.angular_velocity;
  if (!body || body->motion_type != MotionType::kDynamic) return side;
  side.center = pose.Transform(scene_entity.mass.center_of_mass);
  if (!active_[row]) return side;
  side.inverse_mass = 1 / scene_entity.mass.mass;
  side.inverse_tensor = WorldTensor(pose.orientation, scene_entity.mass.inverse_tensor);
  const HalfStep& half = layer_.half_steps[row];
  side.interval = half.Interval(layer_.last_substep, h);
  if (half.restarts) return side;
  side.linear_expected += side.interval * half.held_rate;
  side.angular_expected += side.inverse_tensor * (half.held_momentum * (2 * side.interval / layer_.last_substep));
  return side;
}

ErrorCorrection JointStep::CorrectionOf(const EntityRef& entity) const {
  if (entity.is_world()) return {};
  const auto& body = scene_.entities[entity.id.index()]->desc->rigid_body;
  return body ? body->error_correction : ErrorCorrection{};
}

// What left the bounds of the world is held no longer, and holds nothing.
bool JointStep::MayHold(const JointDesc& desc) const {
  const auto is_gone = [&](const EntityRef& entity) {
    return !entity.id.is_null() && layer_.faulted[entity.id.index()];
  };
  return !is_gone(desc.entity_a) && !is_gone(desc.entity_b);
}

// How far the way of a side over a substep of `h` seconds can be foretold, 0 to 1. A light body that is pulled hard
// swings about its joint by sqrt(pull * arm / moment) rad/s: where a substep does not resolve that, nor the turn
// itself, what is foretold would only drive it.
double JointStep::Trust(const JointSide& side, uint32_t slot, double h) const {
  constexpr double kStiffest = 2, kStiff = 0.5;  // (rad per substep)^2
  constexpr double kWidest = 1.4, kWide = 0.7;   // rad
  const auto fade = [](double value, double full, double none) {
    return std::clamp((none - value) / (none - full), 0.0, 1.0);
  };
  const double turn = side.angular_expected.norm() * h;
  const double arm = (side.frame.position - side.center).norm();
  const double stiffness = layer_.joints[slot].force.norm() * arm * side.inverse_tensor.norm() * h * h;
  return fade(turn, kWide, kWidest) * fade(stiffness, kStiff, kStiffest);
}

bool JointStep::Visit(uint32_t slot, double h, std::vector<JointRow>* rows) {
  const JointDesc& desc = scene_.joints[slot]->desc;
  if (!MayHold(desc)) return false;
  const JointSide a = SideOf(desc.entity_a, *desc.frame_in_a, h);
  const JointSide b = SideOf(desc.entity_b, *desc.frame_in_b, h);
  if (!a.is_movable() && !b.is_movable()) return false;
  expected_.clear();
  const double trust = rows != nullptr ? std::min(Trust(a, slot, h), Trust(b, slot, h)) : 0;
  if (trust > 0) {
    const JointSide a_ahead = a.Ahead(h), b_ahead = b.Ahead(h);
    RowWriter ahead(a_ahead, b_ahead, layer_.joints[slot], expected_);
    std::visit([&](const auto& joint) { WriteRows(joint, ahead); }, desc.kind);
  }
  const ErrorCorrection correction = Gentler(CorrectionOf(desc.entity_a), CorrectionOf(desc.entity_b));
  RowWriter writer(a, b, h, correction, layer_.joints[slot], rows, {expected_, trust});
  std::visit([&](const auto& joint) { WriteRows(joint, writer); }, desc.kind);
  if (rows != nullptr) held_[slot].share = h / writer.interval();
  return true;
}

std::vector<JointRow>& JointStep::Write(double h) {
  rows_.clear();
  owners_.clear();
  if (scene_.joints.empty()) return rows_;
  if (!is_saved_) {
    saved_ = layer_.joints;
    is_saved_ = true;
    held_.assign(scene_.joints.size(), {});
    was_held_.assign(scene_.joints.size(), false);
  }
  for (uint32_t slot = 0; slot < scene_.joints.size(); ++slot) {
    if (!scene_.joints[slot]) continue;
    if (!Visit(slot, h, &rows_)) continue;
    was_held_[slot] = true;
    owners_.resize(rows_.size(), slot);
  }
  return rows_;
}

void JointStep::Take(double h) {
  const auto spin = [&](EntityRow row) -> Vector3 {
    return row == kWorldRow ? Vector3(Vector3::Zero()) : Vector3(state_.angular_velocities.col(Index(row)));
  };
  for (size_t i = 0; i < owners_.size(); ++i) {
    const JointRow& row = rows_[i];
    Held& held = held_[owners_[i]];
    if (row.kind == JointRow::Kind::kLinear) {
      held.force += held.share * row.impulse * row.axis;
    } else if (row.kind == JointRow::Kind::kAngular) {
      held.torque += held.share * row.impulse * row.axis;
    } else {
      held.torque += held.share * row.impulse * row.axis_b;
      // No pose tells how often a gear has turned, so that what it slipped is added up.
      layer_.joints[owners_[i]].positions[5] += h * (row.axis.dot(spin(row.a)) + row.axis_b.dot(spin(row.b)));
    }
  }
}

std::vector<JointId> JointStep::Finish(double step_size) {
  std::vector<JointId> broken;
  for (uint32_t slot = 0; slot < was_held_.size(); ++slot) {
    if (!was_held_[slot] || !scene_.joints[slot]) continue;
    JointState& joint = layer_.joints[slot];
    joint.force = held_[slot].force / step_size;
    joint.torque = held_[slot].torque / step_size;
    Visit(slot, step_size, nullptr);
    const JointDesc& desc = scene_.joints[slot]->desc;
    const bool is_pulled = desc.break_force && joint.force.norm() > *desc.break_force;
    const bool is_twisted = desc.break_torque && joint.torque.norm() > *desc.break_torque;
    if (is_pulled || is_twisted) broken.push_back(scene_.joints[slot]->id);
  }
  std::sort(broken.begin(), broken.end());
  return broken;
}

void JointStep::MarkHeld(std::vector<uint8_t>& held) const {
  for (const std::optional<SceneJoint>& joint : scene_.joints) {
    if (!joint || !MayHold(joint->desc)) continue;
    for (const EntityRow row : {RowOf(joint->desc.entity_a), RowOf(joint->desc.entity_b)}) {
      if (row != kWorldRow) held[Index(row)] = true;
    }
  }
}

void JointStep::Restore() {
  if (is_saved_) layer_.joints = saved_;
}

}  // namespace genphys

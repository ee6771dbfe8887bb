#include "joint_step.h"

#include <algorithm>

#include "free_rotation.h"
#include "joints/kinds.h"

namespace genphys {

JointSide JointStep::SideOf(const EntityRef& entity, const Pose& frame) const {
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
  if (!body || body->motion_type != MotionType::kDynamic) return side;
  side.center = pose.Transform(scene_entity.mass.center_of_mass);
  if (!active_[row]) return side;
  side.inverse_mass = 1 / scene_entity.mass.mass;
  side.inverse_tensor = WorldTensor(pose.orientation, scene_entity.mass.inverse_tensor);
  return side;
}

// What left the bounds of the world is held no longer, and holds nothing.
bool JointStep::MayHold(const JointDesc& desc) const {
  const auto is_gone = [&](const EntityRef& entity) {
    return !entity.id.is_null() && layer_.faulted[entity.id.index()];
  };
  return !is_gone(desc.entity_a) && !is_gone(desc.entity_b);
}

bool JointStep::Visit(uint32_t slot, double h, std::vector<JointRow>* rows) {
  const JointDesc& desc = scene_.joints[slot]->desc;
  if (!MayHold(desc)) return false;
  const JointSide a = SideOf(desc.entity_a, *desc.frame_in_a);
  const JointSide b = SideOf(desc.entity_b, *desc.frame_in_b);
  if (!a.is_movable() && !b.is_movable()) return false;
  RowWriter writer(a, b, h, layer_.joints[slot], rows);
  std::visit([&](const auto& joint) { WriteRows(joint, writer); }, desc.kind);
  return true;
}

std::span<JointRow> JointStep::Write(double h) {
  rows_.clear();
  owners_.clear();
  if (scene_.joints.empty()) return {};
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
  for (size_t i = 0; i < rows_.size(); ++i) {
    const JointRow& row = rows_[i];
    Held& held = held_[owners_[i]];
    if (row.kind == JointRow::Kind::kLinear) {
      held.force += row.impulse * row.axis;
    } else if (row.kind == JointRow::Kind::kAngular) {
      held.torque += row.impulse * row.axis;
    } else {
      held.torque += row.impulse * row.axis_b;
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

void JointStep::Restore() {
  if (is_saved_) layer_.joints = saved_;
}

}  // namespace genphys

#include "support/joints.h"

namespace genphys::testing {
namespace {

Pose FrameOf(const World& world, const EntityRef& entity, const Pose& frame) {
  return entity.is_world() ? frame : world.state().pose(EntityRow{entity.id.index()}).Transform(frame);
}

}  // namespace

std::unique_ptr<World> MakeSpace(const std::string& engine, const StepperDesc& stepper, const Vector3& gravity) {
  return MakeWorld(WorldDesc{.engine = engine,
                             .gravity = gravity,
                             .stepper = stepper,
                             .default_auto_disable = {.enabled = false},
                             .ground_plane = false});
}

JointDesc ToWorld(EntityId b, const JointKind& kind, const Pose& frame) { return Between({}, b, kind, frame); }

JointDesc Between(EntityId a, EntityId b, const JointKind& kind, const Pose& frame_in_a) {
  return {.entity_a = {a, {}}, .entity_b = {b, {}}, .frame_in_a = frame_in_a, .kind = kind};
}

Pose FrameAlong(const Vector3& z, const Vector3& position) {
  return {position, Quaternion::FromTwoVectors(Vector3::UnitZ(), z)};
}

JointId Join(World& world, const JointDesc& joint) { return Do(world, CreateJoint{joint}); }

JointState StateOf(const World& world, JointId id) { return world.joint_state(id); }

double GapOf(const World& world, JointId id) {
  const JointDesc& joint = world.scene().joints[id.index()]->desc;
  return (FrameOf(world, joint.entity_a, *joint.frame_in_a).position -
          FrameOf(world, joint.entity_b, *joint.frame_in_b).position)
      .norm();
}

}  // namespace genphys::testing

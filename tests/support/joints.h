#pragma once
#include <memory>
#include <string>

#include "support/scenes.h"

namespace genphys::testing {

/// A world without floor, in which nothing sleeps.
std::unique_ptr<World> MakeSpace(const std::string& engine, const StepperDesc& stepper = {},
                                 const Vector3& gravity = {0, 0, -9.81});

/// A joint of `b` to the world, whose frame is `frame` there.
JointDesc ToWorld(EntityId b, const JointKind& kind, const Pose& frame = {});
/// A joint whose frame in a is `frame_in_a`; b stays where it is.
JointDesc Between(EntityId a, EntityId b, const JointKind& kind, const Pose& frame_in_a = {});

/// A frame at `position` whose z points along `z`.
Pose FrameAlong(const Vector3& z, const Vector3& position = Vector3::Zero());

JointId Join(World& world, const JointDesc& joint);
JointState StateOf(const World& world, JointId id);
/// How far the origins of both frames are apart, m.
double GapOf(const World& world, JointId id);

}  // namespace genphys::testing

#pragma once
#include <optional>
#include <vector>

#include "genphys/entity.h"
#include "genphys/inertia.h"
#include "genphys/joint.h"

namespace genphys::bench {

/// Of every problem that does not say otherwise, m/s^2.
inline constexpr double kGravity = 9.81;

/// What is simulated, told once for every contender. The centre of mass of each body is the origin of its frame.
struct Scene {
  Vector3 gravity{0, 0, -kGravity};  // m/s^2
  bool has_ground = false;           // an infinite plane at z = 0
  double friction = 0;               // of everything
  double restitution = 0;            // of everything
  bool may_sleep = false;            // who rests may be left out of the steps, as each contender does it by default
  std::vector<EntityDesc> bodies;
  std::vector<JointDesc> joints;  // have both frames and name bodies by their places in `bodies`

  /// Adds a body that moves, and returns its place.
  size_t Add(const Shape& shape, double mass, const Pose& pose, const Vector3& velocity = Vector3::Zero(),
             const Vector3& spin = Vector3::Zero());
  /// Adds one that never does.
  size_t AddStatic(const Shape& shape, const Pose& pose = {});

  /// Joins two bodies, or `b` to the world, where they are, at `anchor` (world, m); `axis` (world, unit length) is that
  /// of a hinge or slider. Returns the place of the joint.
  size_t Join(const JointKind& kind, std::optional<size_t> a, size_t b, const Vector3& anchor,
              const Vector3& axis = Vector3::UnitZ());
};

/// Where `ref` is attached, in Scene::bodies; none: to the world.
std::optional<size_t> PlaceOf(const EntityRef& ref);

/// Whether a joint leaves the coordinates that it has alone: no limits, motor or spring.
bool IsPlain(JointKind kind);

/// Mass and tensor of a body of a scene. std::logic_error if its centre of mass is not the origin of its frame.
MassProperties MassOf(const EntityDesc& body);

Pose At(double x, double y, double z);
/// A turn by `angle` (rad) about `axis` (unit length).
Quaternion Turn(double angle, const Vector3& axis);

}  // namespace genphys::bench

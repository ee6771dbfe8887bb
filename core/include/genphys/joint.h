#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "genphys/ids.h"
#include "genphys/math.h"

namespace genphys {

// What joints are asked to be. Along an axis units are m, N, N/m and N*s/m; about one they are rad, N*m, N*m/rad and
// N*m*s/rad. Each kind is told in the joint frames: frame a is fixed in entity a, frame b in entity b.

/// Where a coordinate may be. Unset: no bound.
struct AxisLimits {
  std::optional<double> lower;
  std::optional<double> upper;  // not below `lower`
  /// Whether they leave no way at all: the coordinate is locked at the lower one.
  bool lock() const { return lower && upper && *lower >= *upper; }
  bool operator==(const AxisLimits&) const = default;
};

/// Drives a coordinate: to a velocity, or by a spring and damper to a position that may itself move.
struct Motor {
  double target_velocity = 0;
  std::optional<double> target_position;  // unset: it drives to the velocity alone, with all its force
  double stiffness = 0;                   // of the drive to the position; more than zero there
  double damping = 0;                     // of the drive to the position, against the target velocity
  std::optional<double> force_max;        // of either sign; unset: as much as it takes
  bool operator==(const Motor&) const = default;
};

/// Pulls a coordinate to `rest`.
struct Spring {
  double stiffness = 0;
  double damping = 0;
  double rest = 0;
  bool operator==(const Spring&) const = default;
};

/// A coordinate that a joint leaves free, and what acts on it.
struct JointAxis {
  AxisLimits limits;
  std::optional<Motor> motor;
  std::optional<Spring> spring;
  bool operator==(const JointAxis&) const = default;
};

/// Point to point: the origins of both frames stay together.
struct BallJoint {
  std::optional<double> swing_max;  // rad, between both z axes
  AxisLimits twist;                 // rad, about z
  bool operator==(const BallJoint&) const = default;
};

/// Point to nail: b turns about z.
struct HingeJoint {
  JointAxis axis;
  bool operator==(const HingeJoint&) const = default;
};

/// Point to path: b slides along z of frame a and does not turn.
struct SliderJoint {
  JointAxis axis;
  bool operator==(const SliderJoint&) const = default;
};

/// b turns about x of frame a and about y of frame b, which stay perpendicular.
struct UniversalJoint {
  JointAxis about_x;
  JointAxis about_y;
  bool operator==(const UniversalJoint&) const = default;
};

/// Both frames stay together.
struct FixedJoint {
  bool operator==(const FixedJoint&) const = default;
};

/// b is a wheel of a: it moves along z of frame a, is steered about that z, and spins about y of frame b.
struct WheelJoint {
  std::optional<JointAxis> suspension;  // unset: none, it stays at the origin of frame a
  std::optional<JointAxis> steering;    // unset: straight ahead
  JointAxis spin;
  bool operator==(const WheelJoint&) const = default;
};

/// b moves along x, y, z of frame a and turns about x of frame a, then about the y so turned, then about z of frame b.
struct SixDofJoint {
  std::array<std::optional<JointAxis>, 3> along;  // x y z; unset: locked at zero
  std::array<std::optional<JointAxis>, 3> about;  // x y z; unset: locked at zero
  bool operator==(const SixDofJoint&) const = default;
};

/// Acts on the distance between the origins of both frames. Without limits, motor and spring it keeps the present one.
struct DistanceJoint {
  JointAxis axis;
  bool operator==(const DistanceJoint&) const = default;
};

/// b turns about z of its frame `ratio` times as fast as a about z of its own, both against the world.
struct GearJoint {
  double ratio = 1;
  bool operator==(const GearJoint&) const = default;
};

using JointKind = std::variant<BallJoint, HingeJoint, SliderJoint, UniversalJoint, FixedJoint, WheelJoint, SixDofJoint,
                               DistanceJoint, GearJoint>;

/// An entity that exists, or one that an earlier CreateEntity of the same batch creates; neither: the world.
struct EntityRef {
  EntityId id;
  std::optional<uint32_t> created_by_command;  // its place in the batch
  bool is_world() const { return id.is_null() && !created_by_command; }
  bool operator==(const EntityRef&) const = default;
};

/// A joint as asked for.
struct JointDesc {
  EntityRef entity_a;
  EntityRef entity_b;
  /// In the frame of the entity, or in the world. Unset: where the other one is when the joint is made; both unset, or
  /// of a distance or a gear: the frame of the entity.
  std::optional<Pose> frame_in_a;
  std::optional<Pose> frame_in_b;
  JointKind kind;
  bool collide_connected = false;      // whether the two may touch each other
  std::optional<double> break_force;   // N; unset: it never breaks
  std::optional<double> break_torque;  // N*m, about the origin of frame b
};

/// Parts of a JointDesc that an update can name; combined as bits.
enum class JointField : uint32_t {
  kFrameInA = 1u << 0,
  kFrameInB = 1u << 1,
  kKind = 1u << 2,    // all of it, maybe another one
  kLimits = 1u << 3,  // of a hinge or slider
  kMotor = 1u << 4,   // of a hinge or slider
  kSpring = 1u << 5,  // of a hinge or slider
  kCollideConnected = 1u << 6,
  kBreakForce = 1u << 7,
  kBreakTorque = 1u << 8,
};

struct JointFields {
  uint32_t bits = 0;
  void Add(JointField field) { bits |= static_cast<uint32_t>(field); }
  bool Has(JointField field) const { return (bits & static_cast<uint32_t>(field)) != 0; }
  bool operator==(const JointFields&) const = default;
};

/// Coordinates of a joint: 0 to 2 along x y z, 3 to 5 about x y z of the joint frame. A hinge has 5, a slider 2, a
/// universal joint 3 and 4, a wheel 2, 5 (steering) and 4 (spin), a ball 3 (swing) and 5 (twist), a distance 0.
inline constexpr size_t kJointCoordinates = 6;

/// What a joint is doing. No solve starts from what the last one found: the rows of one joint are so strongly coupled
/// where it is far from a small body that sweeps which remember begin to swing.
struct JointState {
  std::array<double, kJointCoordinates> positions{};  // m and rad; rotations count full turns
  std::array<double, kJointCoordinates> rates{};      // m/s and rad/s
  Vector3 force = Vector3::Zero();                    // N on b, world, mean over the last step
  Vector3 torque = Vector3::Zero();                   // N*m on b about the origin of frame b, world, likewise
  double haste = 1;  // of the speeds at which errors are taken away: the part asked for, less after it got nowhere

  /// Whether a joint is not only late, but something is in its way.
  bool is_stuck() const { return haste <= 1.0 / 16; }
};

/// The axes of `kind` that may have a motor and are there, in the order in which its motors count.
std::vector<JointAxis*> AxesOf(JointKind& kind);

/// The coordinates of these axes, as kJointCoordinates lists them, in the same order.
std::vector<uint8_t> PlacesOf(const JointKind& kind);

/// The first motor of `kind`, or null.
Motor* FirstMotor(JointKind& kind);

/// Whether anything is locked, whatever limits, springs and motors do.
bool LocksAny(const JointKind& kind);

/// Whether a motor asks for motion, so that what is joined is not left to sleep.
bool IsDriven(const JointKind& kind);

}  // namespace genphys

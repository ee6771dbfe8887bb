#pragma once
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "genphys/entity.h"
#include "genphys/force_field.h"
#include "genphys/ids.h"
#include "genphys/joint.h"
#include "genphys/math.h"
#include "genphys/stepper.h"

namespace genphys {

/// In which coordinates a vector is given.
enum class Coordinates : uint8_t { kWorld, kEntity };

/// Parts of an EntityDesc that an update can name; combined as bits.
enum class EntityField : uint32_t {
  kDisplayName = 1u << 0,
  kPose = 1u << 1,
  kVisual = 1u << 2,
  kRigidBody = 1u << 3,  // all of it: set, replaced or (when unset in the update) removed
  kMotionType = 1u << 4,
  kGeometries = 1u << 5,
  kInertia = 1u << 6,
  kAutoDisable = 1u << 7,
  kLinearVelocity = 1u << 8,
  kAngularVelocity = 1u << 9,
  kLinearDamping = 1u << 10,
  kAngularDamping = 1u << 11,
  kGravityScale = 1u << 12,
  kLinearSpeedMax = 1u << 13,
  kAngularSpeedMax = 1u << 14,
  kLockedAxes = 1u << 15,
  kErrorCorrection = 1u << 16,
  kIgnoredEntities = 1u << 17,
};

struct EntityFields {
  uint32_t bits = 0;
  void Add(EntityField field) { bits |= static_cast<uint32_t>(field); }
  bool Has(EntityField field) const { return (bits & static_cast<uint32_t>(field)) != 0; }
  bool operator==(const EntityFields&) const = default;
};

struct CreateEntity {
  EntityDesc entity;
};

/// Replaces the named `fields` of a live entity by those of `entity`.
struct UpdateEntity {
  EntityId id;
  EntityDesc entity;
  EntityFields fields;
};

struct DeleteEntity {
  EntityId id;
};

/// A force and torque, said in full: nothing about it is left to an engine's habit.
struct ApplyForce {
  EntityId id;
  Vector3 force = Vector3::Zero();   // N
  Vector3 torque = Vector3::Zero();  // N*m
  std::optional<Vector3> point;      // m; unset: the centre of mass. A world point moves with the entity from then on
  Coordinates coordinates = Coordinates::kWorld;  // of force, torque and point
  uint32_t steps = 1;                             // how many steps it acts
  bool replace = false;                           // drop this entity's other pending forces first
  /// A sample of a course that is told anew for each step: from one sample to the next it is taken to go straight, and
  /// the motion under it is of second order. A force that is none stays as it is and jumps, which is exact for what
  /// does. Of one step.
  bool sampled = false;
};

/// An instant change of momentum.
struct ApplyImpulse {
  EntityId id;
  Vector3 linear = Vector3::Zero();   // N*s
  Vector3 angular = Vector3::Zero();  // N*m*s
  std::optional<Vector3> point;
  Coordinates coordinates = Coordinates::kWorld;
};

struct SetVelocity {
  EntityId id;
  std::optional<Vector3> linear;   // of the centre of mass, m/s, world; unset: kept
  std::optional<Vector3> angular;  // rad/s, world; unset: kept
};

struct SetPose {
  EntityId id;
  std::optional<Vector3> position = {};        // m, world; unset: kept
  std::optional<Quaternion> orientation = {};  // unset: kept
  uint32_t over_steps = 0;                     // a kinematic entity moves there in as many, pushing; zero: at once
};

struct SetGravity {
  Vector3 gravity = Vector3::Zero();  // m/s^2
};

struct SetStepper {
  StepperDesc stepper;
};

/// Moves the running world to another engine, state kept. "none" detaches it: nothing moves until one is attached.
struct SetEngine {
  std::string engine;  // short name, as in "ode"
};

/// Forces and torques in world coordinates at centres of mass, for one step: parallel columns. No torques: none.
struct ApplyForceColumns {
  std::vector<EntityId> ids;
  std::vector<Vector3> forces;
  std::vector<Vector3> torques;
  bool sampled = false;  // as in ApplyForce
};

/// Joins two entities, or one to the world. What the description leaves to the present poses is taken from them now.
struct CreateJoint {
  JointDesc joint;
};

/// Replaces the named `fields` of a joint by those of `joint`; the entities that it joins stay.
struct UpdateJoint {
  JointId id;
  JointDesc joint;
  JointFields fields;
};

struct DeleteJoint {
  JointId id;
};

/// Targets of the first motor of each joint: parallel columns.
struct SetMotorColumns {
  std::vector<JointId> ids;
  std::vector<double> velocities;  // m/s or rad/s
  std::vector<double> positions;   // m or rad, of motors that drive to a position; empty: kept
};

/// Adds a force field, which acts until it is deleted. What earlier commands of the same batch create is named by their
/// places in it.
struct CreateForceField {
  ForceField field;
  std::vector<uint32_t> created_by_commands;  // on which it acts besides
  std::optional<uint32_t> spring_a_created_by_command = std::nullopt;
  std::optional<uint32_t> spring_b_created_by_command = std::nullopt;
};

/// Replaces all of a force field.
struct UpdateForceField {
  ForceFieldId id = 0;
  ForceField field;
};

struct DeleteForceField {
  ForceFieldId id = 0;
};

/// The only way to change a world.
using Command = std::variant<CreateEntity, UpdateEntity, DeleteEntity, ApplyForce, ApplyImpulse, SetVelocity, SetPose,
                             SetGravity, SetStepper, SetEngine, ApplyForceColumns, CreateJoint, UpdateJoint,
                             DeleteJoint, SetMotorColumns, CreateForceField, UpdateForceField, DeleteForceField>;

}  // namespace genphys

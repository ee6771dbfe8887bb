#pragma once
#include <cstdint>
#include <memory>
#include <variant>
#include <vector>

#include "genphys/command.h"
#include "genphys/entity.h"
#include "genphys/ids.h"
#include "genphys/math.h"

namespace genphys {

/// Which kinds a world records. What it does not record is not computed and gets no number.
struct EventKinds {
  bool contacts = true;              // began, ended
  bool persisting_contacts = false;  // one per touching pair and step
  bool contact_points = true;        // points inside began and persisted
  bool sensors = true;
  bool sleeping = true;
  bool moving = false;  // started, stopped
  bool joints = true;   // broken ones
  bool changes = true;  // entities, joints and force fields created, updated, deleted; entities faulted
  bool operator==(const EventKinds&) const = default;
};

/// A contact point as told to the outside: from entity a towards entity b.
struct EventContactPoint {
  Vector3 position = Vector3::Zero();
  Vector3 normal = Vector3::UnitZ();
  double depth = 0;
  double normal_impulse = 0;
  Vector3 friction_impulse = Vector3::Zero();
  Vector3 relative_velocity = Vector3::Zero();
  double friction = 0;
  double restitution = 0;
  uint32_t geometry_a = 0;
  uint32_t geometry_b = 0;
};

/// entity_a has the smaller id.
struct EntityPair {
  EntityId a;
  EntityId b;
  auto operator<=>(const EntityPair&) const = default;
};

struct ContactBegan {
  EntityPair pair;
  std::vector<EventContactPoint> points;
};
struct ContactPersisted {
  EntityPair pair;
  std::vector<EventContactPoint> points;
};
struct ContactEnded {
  EntityPair pair;
};
struct SensorEntered {
  EntityId sensor;
  EntityId visitor;
};
struct SensorLeft {
  EntityId sensor;
  EntityId visitor;
};
struct EntitySlept {
  EntityId id;
};
struct EntityWoke {
  EntityId id;
};
/// Rose above the speed at which its AutoDisable calls it at rest, in rotation or in translation.
struct EntityStartedMoving {
  EntityId id;
  bool rotation = false;
};
/// Fell to that speed or below.
struct EntityStoppedMoving {
  EntityId id;
  bool rotation = false;
};
/// Left the bounds of the world: disabled at its last good pose.
struct EntityFaulted {
  EntityId id;
};
/// Held more than it may in a step, and is gone. A null id in the pair is the world.
struct JointBroke {
  JointId joint;
  EntityPair pair;    // as the joint names them
  double force = 0;   // N, mean over the step
  double torque = 0;  // N*m, about the joint frame of b
};
/// As it was at that moment, defaults filled in.
struct EntityCreated {
  EntityId id;
  std::shared_ptr<const EntityDesc> entity;
};
struct EntityUpdated {
  EntityId id;
  std::shared_ptr<const EntityDesc> entity;
  EntityFields fields;
};
struct EntityDeleted {
  EntityId id;
};
/// As it was at that moment, with all that was left open. The pair is as the joint names it; null is the world.
struct JointCreated {
  JointId joint;
  EntityPair pair;
  std::shared_ptr<const JointDesc> desc;
};
struct JointUpdated {
  JointId joint;
  EntityPair pair;
  std::shared_ptr<const JointDesc> desc;
  JointFields fields;
};
/// By a command, or with an entity. One that breaks is told of as that.
struct JointDeleted {
  JointId joint;
  EntityPair pair;
};
/// As it was at that moment. The pair is that of a spring, else null.
struct ForceFieldCreated {
  ForceFieldId field = 0;
  EntityPair pair;
  std::shared_ptr<const ForceField> desc;
};
/// Replaced, or less an entity that is gone.
struct ForceFieldUpdated {
  ForceFieldId field = 0;
  EntityPair pair;
  std::shared_ptr<const ForceField> desc;
};
struct ForceFieldDeleted {
  ForceFieldId field = 0;
  EntityPair pair;
};

/// The order of the alternatives is the canonical order of kinds within a step and within a batch of commands: nothing
/// is named before it is created, nor after it is deleted.
using EventKind = std::variant<EntityCreated, EntityUpdated, JointCreated, JointUpdated, ForceFieldCreated,
                               ForceFieldUpdated, ContactBegan, ContactPersisted, ContactEnded, SensorEntered,
                               SensorLeft, EntityWoke, EntitySlept, EntityStartedMoving, EntityStoppedMoving,
                               EntityFaulted, JointBroke, JointDeleted, ForceFieldDeleted, EntityDeleted>;

struct Event {
  uint64_t sequence = 0;  // dense per world and epoch, from 1
  uint64_t step = 0;      // steps taken when it was true
  EventKind kind;
};

/// Whom it is about: a sensor before its visitor, one that is alone before a null id, and as its pair names them else.
EntityPair EntitiesOf(const EventKind& kind);

}  // namespace genphys

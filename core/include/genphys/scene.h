#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "genphys/capabilities.h"
#include "genphys/entity.h"
#include "genphys/event.h"
#include "genphys/force_field.h"
#include "genphys/ids.h"
#include "genphys/inertia.h"
#include "genphys/joint.h"
#include "genphys/stepper.h"

namespace genphys {

/// What a new world is asked to be. Every field has a default that makes a usable world.
struct WorldDesc {
  std::string engine = "ode";  // short name; "none": nothing moves until one is attached
  Vector3 gravity{0, 0, -9.80665};
  StepperDesc stepper;
  Material default_material;
  AutoDisable default_auto_disable;
  ErrorCorrection default_error_correction;
  std::optional<bool> ground_plane;  // an infinite static floor at z = 0; unset: if the engine has planes
  EventKinds recorded_events;
  std::vector<Feature> required_features;  // creation fails unless the engine has all of these

  bool operator==(const WorldDesc&) const = default;
};

/// What every step asks of a body, side by side: the description that it is taken from lies anywhere in memory, and
/// fetching it costs a body in free flight more than moving it.
struct BodyTraits {
  bool is_dynamic = false;
  bool is_free = false;    // neither a limit of speed nor a locked axis
  bool is_locked = false;  // along or about some axis
  bool may_sleep = false;
  bool corrects = false;  // errors in a way of its own
  double gravity_scale = 1;
  double linear_damping = 0;     // 1/s
  double angular_damping = 0;    // 1/s
  double linear_speed_max = 0;   // m/s, infinite if there is none
  double angular_speed_max = 0;  // rad/s, likewise
  double rest_speed = 0;         // m/s, of what rests at most
  double rest_spin = 0;          // rad/s, likewise
  double rest_time = 0;          // s
};

/// An entity as it was asked for, with every default filled in, and what follows from that alone.
struct SceneEntity {
  SceneEntity(EntityId its_id, std::shared_ptr<const EntityDesc> its_desc, const MassProperties& its_mass);
  /// Makes it another entity with the same id.
  void Become(std::shared_ptr<const EntityDesc> other, const MassProperties& other_mass);

  EntityId id;
  std::shared_ptr<const EntityDesc> desc;
  MassProperties mass;  // meaningful for dynamic bodies
  BodyTraits traits;    // meaningful with a body
};

/// A joint as it was asked for, with every default and both frames filled in and its entities named by id.
struct SceneJoint {
  JointId id;
  JointDesc desc;
};

/// The description of a world: what was asked for, as against what is happening.
struct Scene {
  WorldDesc world;
  std::vector<std::optional<SceneEntity>> entities;  // by row
  std::vector<std::optional<SceneJoint>> joints;     // by slot of the joint's id
  std::map<ForceFieldId, ForceField> force_fields;
};

}  // namespace genphys

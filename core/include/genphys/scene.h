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
};

/// An entity as it was asked for, with every default filled in, and what follows from that alone.
struct SceneEntity {
  EntityId id;
  std::shared_ptr<const EntityDesc> desc;
  MassProperties mass;  // meaningful for dynamic bodies
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

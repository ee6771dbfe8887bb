#pragma once
#include <optional>
#include <variant>
#include <vector>

#include "genphys/ids.h"
#include "genphys/math.h"

namespace genphys {

/// Names a force field of a world; counted from 1 and never used again.
using ForceFieldId = uint64_t;

/// The same push everywhere.
struct UniformField {
  Vector3 force = Vector3::Zero();         // N on each entity
  Vector3 acceleration = Vector3::Zero();  // m/s^2, on top of gravity
};

/// Resistance of a medium, at the centre of mass: F = -(linear + quadratic |v|) v and T = -angular w, where v is the
/// velocity against the medium. A medium that moves is a wind. Slows down exactly over a step, whatever the
/// coefficients, and so never turns a motion round.
struct DragField {
  double linear = 0;                          // N*s/m
  double quadratic = 0;                       // N*s^2/m^2
  double angular = 0;                         // N*m*s
  Vector3 medium_velocity = Vector3::Zero();  // m/s, world
};

/// A spring with a damper between a point of `a` and a point of `b`, or of the world if `b` is null.
struct SpringField {
  EntityId a;
  EntityId b;
  Vector3 point_in_a = Vector3::Zero();  // m, frame of the entity
  Vector3 point_in_b = Vector3::Zero();  // m, frame of the entity, or world
  double rest_length = 0;                // m
  double stiffness = 0;                  // N/m
  double damping = 0;                    // N*s/m
};

/// Pulls towards a point as a mass does: m strength r / (r^2 + softening^2)^(3/2) for an entity of mass m (Plummer).
struct PointGravityField {
  Vector3 center = Vector3::Zero();  // m, world
  double strength = 0;               // G M, m^3/s^2; negative pushes away
  double softening = 1e-3;           // m
};

/// A fluid below a surface: Archimedes' force on what is below, at the centre of its volume, and a drag that grows with
/// the part that is below.
struct BuoyancyField {
  Vector3 surface_normal = Vector3::UnitZ();  // unit length, out of the fluid
  double surface_offset = 0;                  // m: the surface is where dot(normal, p) is this
  double fluid_density = 1000;                // kg/m^3
  DragField drag;                             // of an entity that is all below
};

using ForceFieldKind = std::variant<UniformField, DragField, SpringField, PointGravityField, BuoyancyField>;

/// A box in the world, edges along its axes.
struct Region {
  Vector3 corner = Vector3::Zero();           // m
  Vector3 opposite_corner = Vector3::Zero();  // m
};

/// A force that acts on until it is deleted, computed anew at every substep from where entities are then.
struct ForceField {
  ForceFieldKind kind;
  std::vector<EntityId> entities;  // on which; empty: all dynamic ones. A spring names its own
  std::optional<Region> region;    // only on entities whose centre of mass is in here; unset: everywhere
};

}  // namespace genphys

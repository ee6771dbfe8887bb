#pragma once
#include "genphys/entity.h"
#include "genphys/math.h"

namespace genphys {

/// Which part of a body lies below a plane.
struct Submersion {
  double volume = 0;                 // m^3, of all of the body
  double volume_below = 0;           // m^3
  Vector3 center = Vector3::Zero();  // m, world: of the volume below
};

/// Of the geometries of `body` at `pose`, below the points p with dot(normal, p) = offset. Sensors and shapes without a
/// volume do not count; where geometries overlap, both do, as they do for the mass.
Submersion Submerge(const RigidBody& body, const Pose& pose, const Vector3& normal, double offset);

}  // namespace genphys

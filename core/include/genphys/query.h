#pragma once
#include <cstdint>

#include "genphys/ids.h"
#include "genphys/math.h"

namespace genphys {

/// A segment from `origin` to `origin + translation`, world, m.
struct Ray {
  Vector3 origin = Vector3::Zero();
  Vector3 translation = Vector3::Zero();
};

/// The closest hit of a ray; ties go to the smaller entity id.
struct RayHit {
  EntityId entity;                   // null: no hit
  double fraction = 0;               // 0 to 1 along the translation
  Vector3 normal = Vector3::Zero();  // unit length, out of the surface, world
};

}  // namespace genphys

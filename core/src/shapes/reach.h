#pragma once
#include "genphys/entity.h"

namespace genphys {

/// From `center`, in the frame of the entity, to the farthest point of `geometry`, m; infinite for a plane. Of triangle
/// meshes, heightfields and ellipsoids no less than that.
double ReachFrom(const Vector3& center, const Geometry& geometry);

/// The same of all geometries of a body; zero if it has none.
double ReachFrom(const Vector3& center, const RigidBody& body);

}  // namespace genphys

#pragma once
#include "genphys/contact.h"
#include "genphys/entity.h"
#include "genphys/pair_rule.h"
#include "genphys/state.h"

namespace genphys {

/// m/s, world: how the surface of b runs against that of a, at the present poses.
Vector3 SurfaceVelocity(const PairRule& rule, const StateArrays& state, GeometryRow a, GeometryRow b);

/// Fills in, at the present poses, how the surfaces of each pair run against each other. Costs nothing while none does.
void FillSurfaceVelocities(const PairRule& rule, const StateArrays& state, ContactBuffer& contacts);

/// Whether a surface of `body` runs over it: what touches it is not at rest even where it stands still.
bool HasRunningSurface(const RigidBody& body);

}  // namespace genphys

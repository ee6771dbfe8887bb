#pragma once
#include "genphys/narrow_phase.h"
#include "shapes.h"

namespace genphys::bullet_backend {

/// Finds where `a` and `b` meet at these placements, with nothing remembered from before. Points with a gap of more
/// than kContactGap are left out.
void FindMeeting(const CollisionShape& a, const Placement& placement_a, const CollisionShape& b,
                 const Placement& placement_b, Manifold& meeting);

}  // namespace genphys::bullet_backend

#pragma once
#include "genphys/contact.h"
#include "genphys/narrow_phase.h"

namespace genphys::bullet_backend {

/// m: pairs with a larger gap have no contact point.
inline constexpr double kContactGap = kContactGapMax;

/// Finds where `a` and `b` meet at these placements, with nothing remembered from before. Points with a gap of more
/// than kContactGap are left out.
void FindMeeting(const Shape& a, const Placement& placement_a, const Shape& b, const Placement& placement_b,
                 Manifold& meeting);

}  // namespace genphys::bullet_backend

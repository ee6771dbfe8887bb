#pragma once
#include <cstdint>
#include <vector>

#include "genphys/contact.h"
#include "shapes.h"

namespace genphys::ode_backend {

/// Appends the points at which two shapes overlap or nearly do, with normals from `a` towards `b`, and returns how
/// many: of a pair that has more than eight the deepest and those far from each other, and of one that is the narrow
/// phase's as many as that gives.
uint32_t FindPoints(const PlacedShape& a, const PlacedShape& b, std::vector<ContactPoint>& points);

}  // namespace genphys::ode_backend

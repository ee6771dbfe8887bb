#pragma once
#include <vector>

#include "genphys/contact.h"
#include "shapes.h"

namespace genphys::ode_backend {

/// Appends the points at which two shapes overlap or nearly do, with normals from `a` towards `b`.
void FindPoints(const PlacedShape& a, const PlacedShape& b, std::vector<ContactPoint>& points);

}  // namespace genphys::ode_backend

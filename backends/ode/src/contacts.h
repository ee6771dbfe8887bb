#pragma once
#include <vector>

#include "genphys/contact.h"
#include "shapes.h"

namespace genphys::ode_backend {

/// A geometry that may meet another one, and what ODE has of it.
struct MeetingSide {
  const PlacedGeometry& geometry;
  const OdeShape& ode;

  bool is_plane() const { return std::holds_alternative<Plane>(geometry.shape); }
};

/// Appends the points at which two geometries overlap or nearly do, with normals from `a` towards `b`.
void FindPoints(const MeetingSide& a, const MeetingSide& b, std::vector<ContactPoint>& points);

}  // namespace genphys::ode_backend

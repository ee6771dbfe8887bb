#pragma once
#include <array>

#include "genphys/placement.h"
#include "genphys/shape.h"

namespace genphys::bullet_backend {

/// The corners of the face or edge with which a convex solid meets a plane. World coordinates.
struct SurfaceFeature {
  static constexpr int kVerticesMax = 4;
  std::array<Vector3, kVerticesMax> vertices;
  int count = 0;

  void Add(const Vector3& vertex) { vertices[static_cast<size_t>(count++)] = vertex; }
};

/// What of a box or capsule faces `direction` (unit length).
SurfaceFeature SupportFeature(const Shape& shape, const Placement& placement, const Vector3& direction);

}  // namespace genphys::bullet_backend

#pragma once
#include <optional>

#include "genphys/query.h"
#include "genphys/shape.h"

namespace genphys {

/// Where a ray enters a solid.
struct SurfaceHit {
  double fraction = 0;               // 0 to 1 along the translation
  Vector3 normal = Vector3::Zero();  // out of the surface, unit length
};

/// Where `ray`, given in the frame of `shape`, enters it, by closed form. A ray that starts inside enters nowhere; one
/// that starts on the surface and leads inwards enters at once.
std::optional<SurfaceHit> EnterShape(const Shape& shape, const Ray& ray);

}  // namespace genphys

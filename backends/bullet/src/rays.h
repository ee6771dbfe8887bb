#pragma once
#include <optional>

#include "convert.h"
#include "genphys/query.h"
#include "genphys/shape.h"

namespace genphys::bullet_backend {

struct SurfaceHit {
  double fraction = 0;               // 0 to 1 along the ray
  Vector3 normal = Vector3::Zero();  // unit length, out of the surface, world
};

/// Where a ray enters a solid, by closed form: Bullet's own ray test is an iteration that stops at 1e-4. A ray that
/// starts inside does not enter.
std::optional<SurfaceHit> CastRay(const Ray& ray, const Shape& shape, const Placement& placement);

}  // namespace genphys::bullet_backend

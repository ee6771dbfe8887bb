#include "shapes.h"

namespace genphys::bullet_backend {
namespace {

SurfaceFeature SurfaceOf(const Box& box, const Placement& placement, const Vector3& direction) {
  const Vector3 local = placement.rotation.transpose() * direction;
  int axis = 0;
  local.cwiseAbs().maxCoeff(&axis);
  const int next = (axis + 1) % 3, last = (axis + 2) % 3;
  const double side = local[axis] < 0 ? -1 : 1;
  SurfaceFeature feature;
  for (const auto& [u, v] : {std::pair{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}) {
    Vector3 corner;
    corner[axis] = side * box.half_extents[axis];
    corner[next] = u * box.half_extents[next];
    corner[last] = v * box.half_extents[last];
    feature.Add(placement.Transform(corner));
  }
  return feature;
}

SurfaceFeature SurfaceOf(const Capsule& capsule, const Placement& placement, const Vector3& direction) {
  const Vector3 half = capsule.half_length * placement.rotation.col(2);
  const Vector3 center = placement.position + capsule.radius * direction;
  SurfaceFeature feature;
  feature.Add(center + half);
  feature.Add(center - half);
  return feature;
}

template <typename Other>
SurfaceFeature SurfaceOf(const Other&, const Placement&, const Vector3&) {
  return {};
}

}  // namespace

SurfaceFeature SupportFeature(const Shape& shape, const Placement& placement, const Vector3& direction) {
  return std::visit([&](const auto& s) { return SurfaceOf(s, placement, direction); }, shape);
}

}  // namespace genphys::bullet_backend

#include "shapes.h"

#include <cmath>
#include <numbers>

namespace genphys::bullet_backend {
namespace {

// Up to this sine of its tilt an end of a cylinder has its corners where they were, lest noise in the tilt of a
// standing one should turn them round. The deepest point of the rim is then missed by less than 3e-6 radii.
constexpr double kNoTilt = 1e-5;

// A round side meets a direction in a line while it leans by less than 45 degrees, else it is an end that does.
constexpr double kHalfTurned = std::numbers::sqrt2 / 2;

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

SurfaceFeature SurfaceOf(const Cylinder& cylinder, const Placement& placement, const Vector3& direction) {
  const Vector3 axis = placement.rotation.col(2);
  const double along = axis.dot(direction);
  Vector3 outward = direction - along * axis;
  const double tilt = outward.norm();
  outward = tilt < kNoTilt ? Vector3(placement.rotation.col(0)) : Vector3(outward / tilt);
  const Vector3 half = cylinder.half_length * axis;
  SurfaceFeature feature;
  if (std::abs(along) < kHalfTurned) {
    feature.Add(placement.position + cylinder.radius * outward + half);
    feature.Add(placement.position + cylinder.radius * outward - half);
    return feature;
  }
  const double side = along < 0 ? -1 : 1;
  const Vector3 sideward = axis.cross(outward);
  for (int i = 0; i < SurfaceFeature::kVerticesMax; ++i) {
    const double angle = 2 * std::numbers::pi * i / SurfaceFeature::kVerticesMax;
    feature.Add(placement.position + side * half +
                cylinder.radius * (std::cos(angle) * outward + std::sin(angle) * sideward));
  }
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

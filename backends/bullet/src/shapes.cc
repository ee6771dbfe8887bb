#include "shapes.h"

#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>

namespace genphys::bullet_backend {
namespace {

// Up to this sine of its tilt an end of a cylinder has its corners where they were, lest noise in the tilt of a
// standing one should turn them round. The deepest point of the rim is then missed by less than 3e-6 radii.
constexpr double kNoTilt = 1e-5;

// A round side meets a direction in a line while it leans by less than 45 degrees, else it is an end that does.
constexpr double kHalfTurned = std::numbers::sqrt2 / 2;

// Bullet's search loses its way where two surfaces touch exactly, and finds it again between solids that are smaller by
// a margin. This is its part of the smallest extent, and the most it is in metres.
constexpr double kMargin = 2e-3;
constexpr double kMarginMax = 1e-3;

double MarginOf(double smallest_extent) { return std::min(kMarginMax, kMargin * smallest_extent); }

Vector3 LocalFarthest(const Sphere& sphere, const Vector3& direction) { return sphere.radius * direction; }

Vector3 LocalFarthest(const Box& box, const Vector3& direction) {
  return (direction.array() < 0).select(-box.half_extents, box.half_extents);
}

Vector3 LocalFarthest(const Capsule& capsule, const Vector3& direction) {
  return capsule.radius * direction + Vector3(0, 0, std::copysign(capsule.half_length, direction.z()));
}

Vector3 LocalFarthest(const Cylinder& cylinder, const Vector3& direction) {
  const double across = std::hypot(direction.x(), direction.y());
  const double scale = across > 0 ? cylinder.radius / across : 0;
  return {scale * direction.x(), scale * direction.y(), std::copysign(cylinder.half_length, direction.z())};
}

// Nobody asks: planes have no farthest point, and the others are the narrow phase's.
template <typename Other>
Vector3 LocalFarthest(const Other&, const Vector3&) {
  return Vector3::Zero();
}

SurfaceFeature SurfaceOf(const Sphere& sphere, const Placement& placement, const Vector3& direction, int) {
  SurfaceFeature feature;
  feature.Add(placement.position + sphere.radius * direction);
  return feature;
}

SurfaceFeature SurfaceOf(const Box& box, const Placement& placement, const Vector3& direction, int) {
  const Vector3 local = placement.rotation.transpose() * direction;
  int axis = 0;
  local.cwiseAbs().maxCoeff(&axis);
  const int next = (axis + 1) % 3, last = (axis + 2) % 3;
  const double side = local[axis] < 0 ? -1 : 1;
  SurfaceFeature feature;
  feature.normal = side * placement.rotation.col(axis);
  for (const auto& [u, v] : {std::pair{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}) {
    Vector3 corner;
    corner[axis] = side * box.half_extents[axis];
    corner[next] = u * box.half_extents[next];
    corner[last] = v * box.half_extents[last];
    feature.Add(placement.Transform(corner));
  }
  return feature;
}

SurfaceFeature SurfaceOf(const Capsule& capsule, const Placement& placement, const Vector3& direction, int) {
  const Vector3 half = capsule.half_length * placement.rotation.col(2);
  const Vector3 center = placement.position + capsule.radius * direction;
  SurfaceFeature feature;
  feature.Add(center + half);
  feature.Add(center - half);
  return feature;
}

SurfaceFeature SurfaceOf(const Cylinder& cylinder, const Placement& placement, const Vector3& direction,
                         int rim_vertices) {
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
  feature.normal = side * axis;
  const Vector3 sideward = axis.cross(outward);
  for (int i = 0; i < rim_vertices; ++i) {
    const double angle = 2 * std::numbers::pi * i / rim_vertices;
    feature.Add(placement.position + side * half +
                cylinder.radius * (std::cos(angle) * outward + std::sin(angle) * sideward));
  }
  return feature;
}

template <typename Other>
SurfaceFeature SurfaceOf(const Other&, const Placement&, const Vector3&, int) {
  return {};
}

}  // namespace

CollisionShape::CollisionShape(const Shape& described) : shape(described) {
  if (const auto* box = std::get_if<Box>(&shape)) {
    core = std::make_unique<btBoxShape>(ToBullet(box->half_extents));
    core->setMargin(MarginOf(box->half_extents.minCoeff()));
    padded = std::make_unique<btBoxShape>(ToBullet(box->half_extents.array() + kBoxPadding));
  } else if (const auto* capsule = std::get_if<Capsule>(&shape)) {
    // The margin of a capsule is its radius: what is left is a segment, and nothing is rounded that is not round.
    core = std::make_unique<btCapsuleShapeZ>(capsule->radius, 2 * capsule->half_length);
  } else if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    core = std::make_unique<btCylinderShapeZ>(btVector3(cylinder->radius, cylinder->radius, cylinder->half_length));
    core->setMargin(MarginOf(std::min(cylinder->radius, cylinder->half_length)));
  }
}

Vector3 FarthestPoint(const Shape& shape, const Placement& placement, const Vector3& direction) {
  const Vector3 local = placement.rotation.transpose() * direction;
  return placement.Transform(std::visit([&](const auto& s) { return LocalFarthest(s, local); }, shape));
}

SurfaceFeature SupportFeature(const Shape& shape, const Placement& placement, const Vector3& direction,
                              int rim_vertices) {
  return std::visit([&](const auto& s) { return SurfaceOf(s, placement, direction, rim_vertices); }, shape);
}

}  // namespace genphys::bullet_backend

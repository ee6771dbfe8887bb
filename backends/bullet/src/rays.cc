#include "rays.h"

#include <algorithm>
#include <cmath>

namespace genphys::bullet_backend {
namespace {

// All in the frame of the shape.
using Hit = std::optional<SurfaceHit>;

// Fraction at which `start + t * step`, with components along some axes taken out or not, comes within `radius` of
// zero. The distance of closest approach is found first, since the difference of large squares would lose it.
std::optional<double> EnterRound(const Vector3& start, const Vector3& step, double radius) {
  const double squared_length = step.squaredNorm();
  if (squared_length == 0) return std::nullopt;
  const double nearest = -start.dot(step) / squared_length;
  const double left = radius * radius - (start + nearest * step).squaredNorm();
  if (left < 0) return std::nullopt;
  const double fraction = nearest - std::sqrt(left / squared_length);
  if (fraction < 0 || fraction > 1) return std::nullopt;
  return fraction;
}

Hit Enter(const Sphere& sphere, const Vector3& start, const Vector3& step) {
  const std::optional<double> fraction = EnterRound(start, step, sphere.radius);
  if (!fraction) return std::nullopt;
  return SurfaceHit{*fraction, (start + *fraction * step).normalized()};
}

Hit Enter(const Box& box, const Vector3& start, const Vector3& step) {
  double enter = -1, leave = 1;
  Vector3 normal = Vector3::Zero();
  for (int i = 0; i < 3; ++i) {
    const double side = step[i] > 0 ? -1 : 1;
    const double outside = side * start[i] - box.half_extents[i];
    if (step[i] == 0) {
      if (std::abs(start[i]) > box.half_extents[i]) return std::nullopt;
      continue;
    }
    const double speed = std::abs(step[i]);
    if (outside / speed > enter) {
      enter = outside / speed;
      normal = side * Vector3::Unit(i);
    }
    leave = std::min(leave, (outside + 2 * box.half_extents[i]) / speed);
  }
  if (enter < 0 || enter > leave) return std::nullopt;
  return SurfaceHit{enter, normal};
}

Hit EnterSide(double radius, double half_length, const Vector3& start, const Vector3& step) {
  const Vector3 start_across(start.x(), start.y(), 0), step_across(step.x(), step.y(), 0);
  const std::optional<double> fraction = EnterRound(start_across, step_across, radius);
  if (!fraction || std::abs(start.z() + *fraction * step.z()) > half_length) return std::nullopt;
  return SurfaceHit{*fraction, (start_across + *fraction * step_across).normalized()};
}

Hit Enter(const Capsule& capsule, const Vector3& start, const Vector3& step) {
  const Vector3 nearest(0, 0, std::clamp(start.z(), -capsule.half_length, capsule.half_length));
  if ((start - nearest).norm() < capsule.radius) return std::nullopt;
  if (const Hit side = EnterSide(capsule.radius, capsule.half_length, start, step)) return side;
  Hit first;
  for (const double end : {-capsule.half_length, capsule.half_length}) {
    const Hit cap = Enter(Sphere{capsule.radius}, start - Vector3(0, 0, end), step);
    if (cap && (!first || cap->fraction < first->fraction)) first = cap;
  }
  return first;
}

Hit Enter(const Cylinder& cylinder, const Vector3& start, const Vector3& step) {
  const double side = step.z() > 0 ? -1 : 1;
  const double outside = side * start.z() - cylinder.half_length;
  if (outside >= 0 && step.z() != 0) {
    const double fraction = outside / std::abs(step.z());
    const Vector3 point = start + fraction * step;
    if (fraction <= 1 && std::hypot(point.x(), point.y()) <= cylinder.radius) {
      return SurfaceHit{fraction, side * Vector3::UnitZ()};
    }
  }
  return EnterSide(cylinder.radius, cylinder.half_length, start, step);
}

Hit Enter(const Plane& plane, const Vector3& start, const Vector3& step) {
  const double height = plane.normal.dot(start) - plane.offset, fall = -plane.normal.dot(step);
  if (height < 0 || fall <= 0 || height > fall) return std::nullopt;
  return SurfaceHit{height / fall, plane.normal};
}

}  // namespace

std::optional<SurfaceHit> CastRay(const Ray& ray, const Shape& shape, const Placement& placement) {
  const Vector3 start = placement.ToLocal(ray.origin), step = placement.rotation.transpose() * ray.translation;
  Hit hit = std::visit([&](const auto& s) { return Enter(s, start, step); }, shape);
  if (hit) hit->normal = placement.rotation * hit->normal;
  return hit;
}

}  // namespace genphys::bullet_backend

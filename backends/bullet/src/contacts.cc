#include "contacts.h"

#include <algorithm>
#include <cmath>

#include "shapes.h"

namespace genphys::bullet_backend {
namespace {

struct Solid {
  const Shape& shape;
  const Placement& placement;
};

// Closest point to `p` on the surface of a solid, its outward normal, and the distance (negative inside), all local.
struct Nearest {
  Vector3 normal = Vector3::Zero();
  double distance = 0;
};

Nearest NearestTo(const Sphere& sphere, const Vector3& p) {
  const double length = p.norm();
  return {length > 0 ? Vector3(p / length) : Vector3::UnitZ(), length - sphere.radius};
}

Nearest NearestTo(const Capsule& capsule, const Vector3& p) {
  const double z = std::clamp(p.z(), -capsule.half_length, capsule.half_length);
  const Vector3 out = p - Vector3(0, 0, z);
  const double length = out.norm();
  return {length > 0 ? Vector3(out / length) : Vector3::UnitX(), length - capsule.radius};
}

Nearest NearestTo(const Box& box, const Vector3& p) {
  const Vector3 closest = p.cwiseMin(box.half_extents).cwiseMax(-box.half_extents);
  if (closest != p) {
    const double distance = (p - closest).norm();
    return {(p - closest) / distance, distance};
  }
  int axis = 0;
  const double inside = (box.half_extents - p.cwiseAbs()).minCoeff(&axis);
  return {p[axis] < 0 ? Vector3(-Vector3::Unit(axis)) : Vector3::Unit(axis), -inside};
}

Nearest NearestTo(const Cylinder& cylinder, const Vector3& p) {
  const double out = std::hypot(p.x(), p.y());
  const Vector3 radial = out > 0 ? Vector3(p.x() / out, p.y() / out, 0) : Vector3::UnitX();
  const Vector3 axial = p.z() < 0 ? Vector3(-Vector3::UnitZ()) : Vector3::UnitZ();
  const double past_side = out - cylinder.radius, past_end = std::abs(p.z()) - cylinder.half_length;
  if (past_side > 0 && past_end > 0) {
    const double distance = std::hypot(past_side, past_end);
    return {(past_side * radial + past_end * axial) / distance, distance};
  }
  return past_side > past_end ? Nearest{radial, past_side} : Nearest{axial, past_end};
}

// The narrow phase's.
template <typename Other>
Nearest NearestTo(const Other&, const Vector3&) {
  return {};
}

Nearest NearestTo(const Plane& plane, const Vector3& p) { return {plane.normal, plane.normal.dot(p) - plane.offset}; }

MeetingPoint MeetSphere(const Solid& solid, const Sphere& sphere, const Vector3& center) {
  const Vector3 local = solid.placement.ToLocal(center);
  const Nearest nearest = std::visit([&](const auto& s) { return NearestTo(s, local); }, solid.shape);
  const Vector3 normal = solid.placement.rotation * nearest.normal;
  const double gap = nearest.distance - sphere.radius;
  return {.position = center - (sphere.radius + gap / 2) * normal, .normal = normal, .depth = -gap};
}

void MeetPlane(const Plane& plane, const Placement& placement, const Solid& solid, Manifold& meeting) {
  const Vector3 normal = placement.rotation * plane.normal;
  const double level = normal.dot(placement.position) + plane.offset;
  const SurfaceFeature feature = SupportFeature(solid.shape, solid.placement, -normal);
  for (int i = 0; i < feature.count; ++i) {
    const Vector3& vertex = feature.vertices[static_cast<size_t>(i)];
    const double gap = normal.dot(vertex) - level;
    if (gap <= kContactGap) meeting.Add({.position = vertex - gap / 2 * normal, .normal = normal, .depth = -gap});
  }
}

void MeetBall(const Solid& solid, const Sphere& sphere, const Vector3& center, Manifold& meeting) {
  const MeetingPoint point = MeetSphere(solid, sphere, center);
  if (point.depth >= -kContactGap) meeting.Add(point);
}

void TurnRound(Manifold& meeting) {
  for (int i = 0; i < meeting.count; ++i) {
    Vector3& normal = meeting.points[static_cast<size_t>(i)].normal;
    normal = -normal;
  }
}

}  // namespace

void FindMeeting(const Shape& a, const Placement& placement_a, const Shape& b, const Placement& placement_b,
                 Manifold& meeting) {
  meeting.count = 0;
  if (IsForNarrowPhase(a, b)) {
    FindContacts(a, placement_a, b, placement_b, kContactGap, meeting);
  } else if (const auto* ball_b = std::get_if<Sphere>(&b)) {
    MeetBall({a, placement_a}, *ball_b, placement_b.position, meeting);
  } else if (const auto* ball_a = std::get_if<Sphere>(&a)) {
    MeetBall({b, placement_b}, *ball_a, placement_a.position, meeting);
    TurnRound(meeting);
  } else if (const auto* plane_a = std::get_if<Plane>(&a)) {
    MeetPlane(*plane_a, placement_a, {b, placement_b}, meeting);
  } else if (const auto* plane_b = std::get_if<Plane>(&b)) {
    MeetPlane(*plane_b, placement_b, {a, placement_a}, meeting);
    TurnRound(meeting);
  }
}

}  // namespace genphys::bullet_backend

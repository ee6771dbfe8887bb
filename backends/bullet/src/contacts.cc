#include "contacts.h"

#include <BulletCollision/CollisionDispatch/btBoxBoxDetector.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "points.h"

namespace genphys::bullet_backend {
namespace {

// Within this of one is the cosine between a normal and a face that the contact is taken to be flat on it.
constexpr double kFlat = 1e-4;

struct Solid {
  const CollisionShape& shape;
  const Placement& placement;
};

// Remembers the deepest of the points that a detector of Bullet gives, in its terms.
struct DeepestPoint final : btDiscreteCollisionDetectorInterface::Result {
  std::optional<MeetingPoint> deepest;

  void setShapeIdentifiersA(int, int) override {}
  void setShapeIdentifiersB(int, int) override {}
  void addContactPoint(const btVector3& normal_on_b, const btVector3& point_on_b, btScalar distance) override {
    if (deepest && -distance <= deepest->depth) return;
    deepest = MeetingPoint{.position = FromBullet(point_on_b) + distance / 2 * FromBullet(normal_on_b),
                           .normal = -FromBullet(normal_on_b),
                           .depth = -distance};
  }
};

MeetingPoint Turned(MeetingPoint point) {
  point.normal = -point.normal;
  return point;
}

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
  const Nearest nearest = std::visit([&](const auto& s) { return NearestTo(s, local); }, solid.shape.shape);
  const Vector3 normal = solid.placement.rotation * nearest.normal;
  const double gap = nearest.distance - sphere.radius;
  return {.position = center - (sphere.radius + gap / 2) * normal, .normal = normal, .depth = -gap};
}

void MeetPlane(const Plane& plane, const Placement& placement, const Solid& solid, PointSet& points) {
  const Vector3 normal = placement.rotation * plane.normal;
  const double level = normal.dot(placement.position) + plane.offset;
  const SurfaceFeature feature = SupportFeature(solid.shape.shape, solid.placement, -normal);
  for (int i = 0; i < feature.count; ++i) {
    const Vector3& vertex = feature.vertices[static_cast<size_t>(i)];
    const double gap = normal.dot(vertex) - level;
    points.Add({.position = vertex - gap / 2 * normal, .normal = normal, .depth = -gap});
  }
}

// By how much the box `b` would have to move along `direction` to leave the box `a`.
double OverlapAlong(const Vector3& direction, const Solid& a, const Solid& b) {
  return direction.dot(FarthestCorner(std::get<Box>(a.shape.shape), a.placement, direction) -
                       FarthestCorner(std::get<Box>(b.shape.shape), b.placement, -direction));
}

std::optional<MeetingPoint> MeetBoxes(const Solid& a, const Solid& b) {
  btDiscreteCollisionDetectorInterface::ClosestPointInput input;
  input.m_transformA = ToTransform(a.placement);
  input.m_transformB = ToTransform(b.placement);
  DeepestPoint result;
  btBoxBoxDetector(a.shape.padded.get(), b.shape.padded.get()).getClosestPoints(input, result, nullptr);
  // Bullet's boxes are padded, and between edges it counts in something against rounding.
  if (result.deepest) result.deepest->depth = OverlapAlong(result.deepest->normal, a, b);
  return result.deepest;
}

// All points in which two boxes meet, of which one point and the normal are known.
void Spread(const Solid& a, const Solid& b, const MeetingPoint& known, PointSet& points) {
  const SurfaceFeature feature_a = SupportFeature(a.shape.shape, a.placement, known.normal);
  const SurfaceFeature feature_b = SupportFeature(b.shape.shape, b.placement, -known.normal);
  const double flat_a = feature_a.normal.dot(known.normal), flat_b = -feature_b.normal.dot(known.normal);
  // Of two faces that are as good as parallel the same one is taken every time.
  if (flat_a >= 1 - kFlat && flat_a >= flat_b - kFlat * kFlat) {
    ClipToPolygon(feature_a, SupportFeature(b.shape.shape, b.placement, -feature_a.normal), false, points);
  } else if (flat_b >= 1 - kFlat) {
    ClipToPolygon(feature_b, SupportFeature(a.shape.shape, a.placement, -feature_b.normal), true, points);
  }
  // Else edges cross.
  if (points.is_empty()) points.Add(known);
}

void FindPoints(const Solid& a, const Solid& b, PointSet& points) {
  if (const auto* sphere = std::get_if<Sphere>(&b.shape.shape)) {
    points.Add(MeetSphere(a, *sphere, b.placement.position));
  } else if (const auto* other = std::get_if<Sphere>(&a.shape.shape)) {
    points.Add(Turned(MeetSphere(b, *other, a.placement.position)));
  } else if (const auto* plane = std::get_if<Plane>(&a.shape.shape)) {
    MeetPlane(*plane, a.placement, b, points);
  } else {
    const std::optional<MeetingPoint> known = MeetBoxes(a, b);
    if (known && known->depth >= -kContactGap) Spread(a, b, *known, points);
  }
}

}  // namespace

void FindMeeting(const CollisionShape& a, const Placement& placement_a, const CollisionShape& b,
                 const Placement& placement_b, Manifold& meeting) {
  if (IsForNarrowPhase(a.shape, b.shape)) {
    return FindContacts(a.shape, placement_a, b.shape, placement_b, kContactGap, meeting);
  }
  meeting.count = 0;
  PointSet points;
  if (std::holds_alternative<Plane>(b.shape)) {
    FindPoints({b, placement_b}, {a, placement_a}, points);
    points.ReduceTo(meeting);
    for (int i = 0; i < meeting.count; ++i) {
      MeetingPoint& point = meeting.points[static_cast<size_t>(i)];
      point = Turned(point);
    }
    return;
  }
  FindPoints({a, placement_a}, {b, placement_b}, points);
  points.ReduceTo(meeting);
}

}  // namespace genphys::bullet_backend

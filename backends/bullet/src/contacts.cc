#include "contacts.h"

#include <BulletCollision/CollisionDispatch/btBoxBoxDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "points.h"

namespace genphys::bullet_backend {
namespace {

// Within this of one is the cosine between a normal and a face that the contact is taken to be flat on it.
constexpr double kFlat = 1e-4;
// Sine between two round sides below which they are taken to lie along each other.
constexpr double kParallel = 1e-3;
// Cosine between an axis and what stands square to it, for rounding.
constexpr double kSquare = 1e-6;
// Cosine between a round side's axis and the normal below which it is the side that meets, not the end.
constexpr double kAcross = 0.1;
// m: what is found from the corners may be shallower by this much than what the detector told.
constexpr double kMissed = 5e-4;
// A depth may fall short of the overlap in its direction by this part of it and by so many metres.
constexpr double kTrusted = 0.05;
constexpr double kTrustedDepth = 2e-3;
// A flat end that meets something flat is round enough with eight corners; four are all that can be kept on a plane.
constexpr int kRimVertices = 8;
constexpr int kRimVerticesOnPlane = 4;

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
  const SurfaceFeature feature = SupportFeature(solid.shape.shape, solid.placement, -normal, kRimVerticesOnPlane);
  for (int i = 0; i < feature.count; ++i) {
    const Vector3& vertex = feature.vertices[static_cast<size_t>(i)];
    const double gap = normal.dot(vertex) - level;
    points.Add({.position = vertex - gap / 2 * normal, .normal = normal, .depth = -gap});
  }
}

// A capsule or cylinder as its axis and how thick it is.
struct Round {
  double radius = 0;
  double half_length = 0;
  bool is_capped = false;  // by hemispheres
};

std::optional<Round> AsRound(const Shape& shape) {
  if (const auto* capsule = std::get_if<Capsule>(&shape)) return Round{capsule->radius, capsule->half_length, true};
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    return Round{cylinder->radius, cylinder->half_length, false};
  }
  return std::nullopt;
}

// Places along two axes, measured from their middles, where these come closest.
struct ClosestPlaces {
  double on_a = 0;
  double on_b = 0;
};

ClosestPlaces FindClosest(const Vector3& between, const Vector3& axis_a, double half_a, const Vector3& axis_b,
                          double half_b) {
  const double cosine = axis_a.dot(axis_b), along_a = axis_a.dot(between), along_b = axis_b.dot(between);
  const double spread = 1 - cosine * cosine;
  // Of parallel axes every place is closest where both run: the middle stands for them.
  const double overlap_middle = (std::max(-half_a, along_a - half_b) + std::min(half_a, along_a + half_b)) / 2;
  const double on_a = spread > kParallel * kParallel ? (along_a - cosine * along_b) / spread : overlap_middle;
  ClosestPlaces places{std::clamp(on_a, -half_a, half_a), 0};
  places.on_b = std::clamp(cosine * places.on_a - along_b, -half_b, half_b);
  places.on_a = std::clamp(along_a + cosine * places.on_b, -half_a, half_a);
  return places;
}

// Bullet's search for the closest points of round sides stops at a normal that is off by up to 1e-4, and there is no
// need to search. Nothing if an end of a cylinder may be what meets.
std::optional<MeetingPoint> MeetRoundSides(const Solid& a, const Solid& b) {
  const std::optional<Round> round_a = AsRound(a.shape.shape), round_b = AsRound(b.shape.shape);
  if (!round_a || !round_b) return std::nullopt;
  const Vector3 axis_a = a.placement.rotation.col(2), axis_b = b.placement.rotation.col(2);
  const Vector3 middle_a = a.placement.position, middle_b = b.placement.position;
  const ClosestPlaces places =
      FindClosest(middle_b - middle_a, axis_a, round_a->half_length, axis_b, round_b->half_length);
  const Vector3 on_a = middle_a + places.on_a * axis_a, on_b = middle_b + places.on_b * axis_b;
  const double distance = (on_b - on_a).norm();
  if (!(distance > 0)) return std::nullopt;
  const Vector3 normal = (on_b - on_a) / distance;
  const double gap = distance - round_a->radius - round_b->radius;
  // Between places inside both axes the line of centres is square to each, and it is the way out of an overlap if the
  // ends are farther away. A hemisphere meets under any angle.
  const auto is_side = [&](const Round& round, const Vector3& axis, double place) {
    return round.is_capped || (std::abs(normal.dot(axis)) < kSquare && round.half_length - std::abs(place) > -gap);
  };
  if (!is_side(*round_a, axis_a, places.on_a) || !is_side(*round_b, axis_b, places.on_b)) return std::nullopt;
  return MeetingPoint{.position = on_a + (round_a->radius + gap / 2) * normal, .normal = normal, .depth = -gap};
}

// By how much `b` would have to move along `direction` to leave `a`.
double OverlapAlong(const Vector3& direction, const Solid& a, const Solid& b) {
  return direction.dot(FarthestPoint(a.shape.shape, a.placement, direction) -
                       FarthestPoint(b.shape.shape, b.placement, -direction));
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

// The shallowest of the ways out that the axes of the two solids suggest.
MeetingPoint MeetAlongAxes(const Solid& a, const Solid& b) {
  const Vector3 between = b.placement.position - a.placement.position;
  MeetingPoint best{.depth = std::numeric_limits<double>::infinity()};
  const auto try_direction = [&](const Vector3& direction) {
    const double length = direction.norm();
    if (length < kParallel) return;
    const double sign = direction.dot(between) < 0 ? -1 : 1;
    const Vector3 normal = sign / length * direction;
    const double depth = OverlapAlong(normal, a, b);
    if (depth >= best.depth) return;
    best = {.position = (FarthestPoint(a.shape.shape, a.placement, normal) +
                         FarthestPoint(b.shape.shape, b.placement, -normal)) /
                        2,
            .normal = normal,
            .depth = depth};
  };
  try_direction(between);
  for (const Placement* placement : {&a.placement, &b.placement}) {
    const Vector3 axis = placement->rotation.col(2);
    try_direction(between - axis.dot(between) * axis);
    for (int i = 0; i < 3; ++i) try_direction(placement->rotation.col(i));
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) try_direction(a.placement.rotation.col(i).cross(b.placement.rotation.col(j)));
  }
  return best;
}

std::optional<MeetingPoint> MeetCores(const Solid& a, const Solid& b) {
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver penetration;
  btDiscreteCollisionDetectorInterface::ClosestPointInput input;
  input.m_transformA = ToTransform(a.placement);
  input.m_transformB = ToTransform(b.placement);
  const double reach = a.shape.core->getMargin() + b.shape.core->getMargin() + kContactGap;
  input.m_maximumDistanceSquared = reach * reach;
  DeepestPoint result;
  btGjkPairDetector(a.shape.core.get(), b.shape.core.get(), &simplex, &penetration)
      .getClosestPoints(input, result, nullptr);
  if (!result.deepest) return std::nullopt;
  // Bullet's solids are rounded by their margins, and in deep overlaps its search sometimes ends at a direction in
  // which they overlap by far more than it tells.
  const double overlap = OverlapAlong(result.deepest->normal, a, b);
  if (overlap > (1 + kTrusted) * std::max(0.0, result.deepest->depth) + kTrustedDepth) return MeetAlongAxes(a, b);
  result.deepest->depth = overlap;
  return result.deepest;
}

// All points of a contact of which one point and the normal are known.
void Spread(const Solid& a, const Solid& b, const MeetingPoint& known, PointSet& points) {
  const SurfaceFeature feature_a = SupportFeature(a.shape.shape, a.placement, known.normal, kRimVertices);
  const SurfaceFeature feature_b = SupportFeature(b.shape.shape, b.placement, -known.normal, kRimVertices);
  const double flat_a = feature_a.is_polygon() ? feature_a.normal.dot(known.normal) : -1;
  const double flat_b = feature_b.is_polygon() ? -feature_b.normal.dot(known.normal) : -1;
  // Of two faces that are as good as parallel the same one is taken every time.
  if (flat_a >= 1 - kFlat && flat_a >= flat_b - kFlat * kFlat) {
    const SurfaceFeature incident = SupportFeature(b.shape.shape, b.placement, -feature_a.normal, kRimVertices);
    ClipToPolygon(feature_a, incident, false, points);
  } else if (flat_b >= 1 - kFlat) {
    const SurfaceFeature incident = SupportFeature(a.shape.shape, a.placement, -feature_b.normal, kRimVertices);
    ClipToPolygon(feature_b, incident, true, points);
  } else if (feature_a.count == 2 && feature_b.count == 2) {
    const Vector3 along_a = (feature_a.vertices[1] - feature_a.vertices[0]).normalized();
    const Vector3 along_b = (feature_b.vertices[1] - feature_b.vertices[0]).normalized();
    if (along_a.cross(along_b).norm() < kParallel && std::abs(along_a.dot(known.normal)) < kAcross) {
      OverlapSegments(feature_a, feature_b, known.normal, points);
    }
  }
  // The corners of a round end do not reach its rim everywhere, so that the deepest place may have been cut off. Of two
  // boxes the known depth may be that of a corner that hangs over the edge.
  const bool are_boxes = a.shape.padded && b.shape.padded;
  if (points.is_empty() || (!are_boxes && points.deepest() < known.depth - kMissed)) points.Add(known);
}

void FindPoints(const Solid& a, const Solid& b, PointSet& points) {
  if (const auto* sphere = std::get_if<Sphere>(&b.shape.shape)) {
    points.Add(MeetSphere(a, *sphere, b.placement.position));
  } else if (const auto* other = std::get_if<Sphere>(&a.shape.shape)) {
    points.Add(Turned(MeetSphere(b, *other, a.placement.position)));
  } else if (const auto* plane = std::get_if<Plane>(&a.shape.shape)) {
    MeetPlane(*plane, a.placement, b, points);
  } else {
    std::optional<MeetingPoint> known = a.shape.padded && b.shape.padded ? MeetBoxes(a, b) : MeetRoundSides(a, b);
    if (!known && !(a.shape.padded && b.shape.padded)) known = MeetCores(a, b);
    if (known && known->depth >= -kContactGap) Spread(a, b, *known, points);
  }
}

}  // namespace

void FindMeeting(const CollisionShape& a, const Placement& placement_a, const CollisionShape& b,
                 const Placement& placement_b, Manifold& meeting) {
  if (IsForNarrowPhase(a.shape) || IsForNarrowPhase(b.shape)) {
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

#include "genphys/narrow_phase.h"

#include <algorithm>

#include "genphys/bounds.h"
#include "genphys/work_watch.h"
#include "shapes/box_contacts.h"
#include "shapes/clipping.h"
#include "shapes/separation.h"
#include "shapes/surface_contacts.h"

namespace genphys {
namespace {

// Points of two surfaces, of which one or both are sensors: that they meet is all that anybody wants to know.
constexpr int kPointsOfSurfaces = 4;

// Of a WorkWatch, for two shapes with few corners.
constexpr int64_t kPairWork = 64;

void TurnRound(Manifold& manifold) {
  for (int i = 0; i < manifold.count; ++i) {
    Vector3& normal = manifold.points[static_cast<size_t>(i)].normal;
    normal = -normal;
  }
}

// Solids at places near the origin.
void MeetSolids(const Solid& a, const Solid& b, double gap, Manifold& manifold) {
  const Separation separation = FindSeparation(a, b, gap);
  if (!(separation.depth >= -gap)) return;
  PointSet points(gap);
  AddFlatPoints(a, b, separation.normal, points);
  if (points.is_empty()) {
    points.Add({.position = separation.place, .normal = separation.normal, .depth = separation.depth});
  }
  points.ReduceTo(manifold);
}

// Dot(normal, p) <= level is solid.
void MeetHalfSpace(const Vector3& normal, double level, const Solid& solid, double gap, Manifold& manifold) {
  PointSet points(gap);
  for (const Vector3& corner : solid.FeatureAt(-normal).corners) {
    const double height = normal.dot(corner) - solid.radius() - level;
    points.Add({.position = corner - (solid.radius() + height / 2) * normal, .normal = normal, .depth = -height});
  }
  points.ReduceTo(manifold);
}

// The triangle that lies in the frame of `placement`, in the frame that this is given in.
SurfaceTriangle Moved(SurfaceTriangle triangle, const Placement& placement) {
  for (Vector3& corner : triangle.corners) corner = placement.Transform(corner);
  return triangle;
}

// Of two surfaces, one point for each pair of triangles that touch. All in the frame of the first.
void MeetSurfaces(const Shape& surface, const Shape& other, const Placement& placement, double gap,
                  Manifold& manifold) {
  const Placement here = placement.ToLocal(Placement{});
  const auto wants_more = [&] { return manifold.count < kPointsOfSurfaces; };
  VisitTrianglesIn(surface, BoundsOf(other, placement).Widened(gap), [&](const SurfaceTriangle& triangle) {
    const Solid solid(triangle);
    const Vector3 first = here.Transform(triangle.corners[0]);
    Bounds bounds{first, first};
    for (const Vector3& corner : Moved(triangle, here).corners) bounds = bounds.Union({corner, corner});
    WorkWatch::Look(kTriangleWork);
    VisitTrianglesIn(other, bounds.Widened(gap), [&](const SurfaceTriangle& theirs) {
      WorkWatch::Look(kTriangleWork);
      const SurfaceTriangle moved = Moved(theirs, placement);
      const Separation separation = FindSeparation(solid, Solid(moved));
      if (separation.depth >= -gap) {
        manifold.Add({.position = separation.place, .normal = separation.normal, .depth = separation.depth});
      }
      return wants_more();
    });
    return wants_more();
  });
}

void MeetSurfaceAndPlane(const Shape& surface, const Plane& plane, const Placement& placement, double gap,
                         Manifold& manifold) {
  const Vector3 normal = placement.rotation * plane.normal;
  const double level = plane.offset + normal.dot(placement.position);
  const auto test = [&](const SurfaceTriangle& triangle) {
    WorkWatch::Look(kTriangleWork);
    MeetHalfSpace(normal, level, Solid(triangle), gap, manifold);
    return manifold.count < kPointsOfSurfaces;
  };
  VisitTrianglesIn(surface, BoundsOf(surface, {}), test);
  TurnRound(manifold);
}

// All in the frame of `surface`.
void MeetSurfaceAnd(const Shape& surface, const Shape& other, const Placement& placement, double gap,
                    Manifold& manifold) {
  if (IsSurface(other)) return MeetSurfaces(surface, other, placement, gap, manifold);
  if (const auto* plane = std::get_if<Plane>(&other)) {
    return MeetSurfaceAndPlane(surface, *plane, placement, gap, manifold);
  }
  FindSurfaceContacts(surface, other, placement, gap, manifold);
}

void ToWorld(const Placement& placement, Manifold& manifold) {
  for (int i = 0; i < manifold.count; ++i) {
    MeetingPoint& point = manifold.points[static_cast<size_t>(i)];
    point.position = placement.Transform(point.position);
    point.normal = placement.rotation * point.normal;
  }
}

// `b` is no surface. In the frame of the world, moved to where `b` is, for what is near zero is not rounded.
void MeetConvex(const Shape& a, const Placement& placement_a, const Shape& b, const Placement& placement_b, double gap,
                Manifold& manifold) {
  const auto *box_a = std::get_if<Box>(&a), *box_b = std::get_if<Box>(&b);
  if (box_a && box_b) {
    PointSet points(gap);
    if (AddBoxPoints(*box_a, placement_a, *box_b, placement_b, gap, points)) return points.ReduceTo(manifold);
  }
  const Solid solid(b, {Vector3::Zero(), placement_b.rotation});
  const Vector3 place_a = placement_a.position - placement_b.position;
  if (const auto* plane = std::get_if<Plane>(&a)) {
    const Vector3 normal = placement_a.rotation * plane->normal;
    MeetHalfSpace(normal, plane->offset + normal.dot(place_a), solid, gap, manifold);
  } else {
    MeetSolids(Solid(a, {place_a, placement_a.rotation}), solid, gap, manifold);
  }
  ToWorld({placement_b.position, Matrix3::Identity()}, manifold);
}

// What no engine has as it should be.
bool IsOurs(const Shape& shape) {
  return std::holds_alternative<Cone>(shape) || std::holds_alternative<Ellipsoid>(shape) ||
         std::holds_alternative<ConvexHull>(shape) || IsSurface(shape);
}

bool IsRound(const Shape& shape) {
  return std::holds_alternative<Capsule>(shape) || std::holds_alternative<Cylinder>(shape);
}

// Against these there is a closed form for all that is round.
bool IsSmooth(const Shape& shape) {
  return std::holds_alternative<Sphere>(shape) || std::holds_alternative<Plane>(shape);
}

bool IsDrumOnPlane(const Shape& drum, const Shape& plane) {
  return std::holds_alternative<Cylinder>(drum) && std::holds_alternative<Plane>(plane);
}

}  // namespace

bool IsForNarrowPhase(const Shape& a, const Shape& b) {
  const bool are_boxes = std::holds_alternative<Box>(a) && std::holds_alternative<Box>(b);
  if (IsOurs(a) || IsOurs(b) || are_boxes || IsDrumOnPlane(a, b) || IsDrumOnPlane(b, a)) return true;
  return IsRound(a) ? !IsSmooth(b) : IsRound(b) && !IsSmooth(a);
}

void FindContacts(const Shape& a, const Placement& placement_a, const Shape& b, const Placement& placement_b,
                  double gap, Manifold& manifold) {
  manifold.count = 0;
  WorkWatch::Look(kPairWork);
  const bool is_plane_b = std::holds_alternative<Plane>(b);
  if (is_plane_b && std::holds_alternative<Plane>(a)) return;
  if (IsSurface(a)) {
    MeetSurfaceAnd(a, b, placement_a.ToLocal(placement_b), gap, manifold);
    ToWorld(placement_a, manifold);
  } else if (IsSurface(b) || is_plane_b) {
    FindContacts(b, placement_b, a, placement_a, gap, manifold);
    TurnRound(manifold);
  } else {
    MeetConvex(a, placement_a, b, placement_b, gap, manifold);
  }
}

}  // namespace genphys

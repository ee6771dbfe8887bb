#include "genphys/proximity.h"

#include <algorithm>
#include <cmath>

#include "genphys/bounds.h"
#include "genphys/narrow_phase.h"
#include "shapes/separation.h"
#include "shapes/surface_contacts.h"

namespace genphys {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kAdvancesMax = 64;
// Of the smaller size: a gap that is no more.
constexpr double kArrived = 1e-10;
// Of a distance: far more than what the gap between bounds is rounded by. What is as near as the best of another
// shape must be found, to be told from it.
constexpr double kRounding = 1e-12;
// Of a WorkWatch, for a triangle and a solid: how near they are, or where the one meets the other.
constexpr int64_t kMeetingWork = 256;
// Length of the sum of the normals of two planes that face each other, up to rounding.
constexpr double kParallel = 1e-9;

Proximity Turned(Proximity p) {
  std::swap(p.on_a, p.on_b);
  p.normal = -p.normal;
  return p;
}

Proximity ToProximity(const Separation& s) {
  const Vector3 half = s.depth / 2 * s.normal;
  return {-s.depth, s.place + half, s.place - half, s.normal};
}

Proximity BetweenSolids(const Solid& a, const Solid& b) { return ToProximity(FindSeparation(a, b)); }

// Of the solid half-space dot(normal, p) <= level.
Proximity FromHalfSpace(const Vector3& normal, double level, const Solid& solid) {
  const Vector3 lowest = solid.Support(-normal) - solid.radius() * normal;
  const double height = normal.dot(lowest) - level;
  return {height, lowest - height * normal, lowest, normal};
}

// Calls visit(triangle) for those of a surface that may be nearer to `bounds`, in its frame, than `within` m.
template <typename Visit>
void VisitNear(const Shape& surface, const Bounds& bounds, const double& within, Visit&& visit) {
  if (const auto* mesh = std::get_if<TriangleMesh>(&surface)) VisitNearTriangles(*mesh->data, bounds, within, visit);
  if (const auto* field = std::get_if<Heightfield>(&surface)) VisitNearTriangles(*field->data, bounds, within, visit);
}

// The solid's bounds are `bounds`; all in the frame of the surface.
Proximity FromTriangles(const Shape& surface, const Solid& solid, const Bounds& bounds, double within) {
  Proximity best{.distance = within};
  double reach = within * (1 + kRounding);
  VisitNear(surface, bounds, reach, [&](const SurfaceTriangle& triangle) {
    WorkWatch::Spend(kMeetingWork);
    const Proximity found = BetweenSolids(Solid(triangle), solid);
    if (!(found.distance < best.distance)) return;
    best = found;
    reach = found.distance;
  });
  return best;
}

// In the frame of the surface, moved to where the shape is.
Proximity FromSurface(const Shape& surface, const Shape& shape, const Placement& placement, double within) {
  Manifold manifold;
  FindSurfaceContacts(surface, shape, placement, 0, manifold);
  if (manifold.count == 0) return FromTriangles(surface, Solid(shape, placement), BoundsOf(shape, placement), within);
  const auto end = manifold.points.begin() + manifold.count;
  const MeetingPoint& deepest =
      *std::max_element(manifold.points.begin(), end, [](const auto& a, const auto& b) { return a.depth < b.depth; });
  const Vector3 half = deepest.depth / 2 * deepest.normal;
  return {-deepest.depth, deepest.position + half, deepest.position - half, deepest.normal};
}

// Of a surface without what lies below it, which belongs to the bounds of the shape.
Bounds BoundsOfWhatIsThere(const Shape& shape, const Placement& placement) {
  const auto* field = std::get_if<Heightfield>(&shape);
  if (field == nullptr) return BoundsOf(shape, placement);
  const Bounds own = BoundsOf(*field->data);
  const Vector3 center = placement.Transform(Vector3((own.min + own.max) / 2));
  const Vector3 half = placement.rotation.cwiseAbs() * (own.max - own.min) / 2;
  return {center - half, center + half};
}

// Of the triangles of a surface and anything without bounds or with triangles of its own; in the frame of the surface.
Proximity FromSurfaceToRest(const Shape& surface, const Shape& other, const Placement& placement, double within) {
  Proximity best{.distance = within};
  VisitNear(surface, BoundsOfWhatIsThere(other, placement), best.distance, [&](const SurfaceTriangle& triangle) {
    const Solid solid(triangle);
    if (const auto* plane = std::get_if<Plane>(&other)) {
      const Vector3 normal = placement.rotation * plane->normal;
      const Proximity found = Turned(FromHalfSpace(normal, plane->offset + normal.dot(placement.position), solid));
      if (found.distance < best.distance) best = found;
      return;
    }
    SurfaceTriangle there = triangle;
    for (Vector3& corner : there.corners) corner = placement.ToLocal(corner);
    const auto& [a, b, c] = there.corners;
    const Bounds bounds{a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
    const Proximity found = FromTriangles(other, Solid(there), bounds, best.distance);
    if (found.distance < best.distance) {
      best = {found.distance, placement.Transform(found.on_b), placement.Transform(found.on_a),
              placement.rotation * -found.normal};
    }
  });
  return best;
}

Proximity BetweenPlanes(const Vector3& normal_a, double level_a, const Vector3& normal_b, double level_b) {
  const double gap = -level_a - level_b;
  if ((normal_a + normal_b).norm() > kParallel || gap < 0) return {.distance = 0, .normal = normal_a};
  return {gap, level_a * normal_a, level_b * normal_b, normal_a};
}

void Move(Proximity& p, const Placement& placement) {
  p.on_a = placement.Transform(p.on_a);
  p.on_b = placement.Transform(p.on_b);
  p.normal = placement.rotation * p.normal;
}

// `b` is no plane, unless both are; `a` is a surface if one of them is.
Proximity Find(const Shape& a, const Placement& placement_a, const Shape& b, const Placement& placement_b,
               double within) {
  Proximity found;
  if (IsSurface(a)) {
    const Placement placement = placement_a.ToLocal(placement_b);
    found = IsConvex(b) ? FromSurface(a, b, placement, within) : FromSurfaceToRest(a, b, placement, within);
    Move(found, placement_a);
    return found;
  }
  const Vector3 place_a = placement_a.position - placement_b.position;
  if (const auto* plane = std::get_if<Plane>(&a)) {
    const Vector3 normal = placement_a.rotation * plane->normal;
    const double level = plane->offset + normal.dot(place_a);
    if (const auto* other = std::get_if<Plane>(&b)) {
      found = BetweenPlanes(normal, level, placement_b.rotation * other->normal, other->offset);
    } else {
      found = FromHalfSpace(normal, level, Solid(b, {Vector3::Zero(), placement_b.rotation}));
    }
  } else {
    found = BetweenSolids(Solid(a, {place_a, placement_a.rotation}), Solid(b, {Vector3::Zero(), placement_b.rotation}));
  }
  Move(found, {placement_b.position, Matrix3::Identity()});
  return found;
}

// From the moving solid to the other one, which is at rest. Each step goes to where the plane between the closest
// points is reached, before which nothing can be hit (as in conservative advancement, but exact for the plane).
std::optional<ShapeHit> Sweep(const Solid& moving, const Vector3& translation, const Solid& target,
                              double fraction_max) {
  const double size = std::min(moving.size(), target.size());
  ShapeHit hit;
  for (int i = 0; i < kAdvancesMax; ++i) {
    const Vector3 moved = hit.fraction * translation;
    const CorePoints core = FindCorePoints(moving, target, {.shift = -moved, .nothing = kArrived * size});
    if (!(core.distance > 0)) {
      if (i > 0) return hit;
      const Separation separation = FindSeparation(moving, target);
      return ShapeHit{0, separation.place, -separation.normal};
    }
    const Vector3& normal = core.normal;
    const double approach = normal.dot(translation);
    const double gap = -OverlapAlong(moving, target, normal) - hit.fraction * approach;
    if (i == 0 && gap <= 0) return ShapeHit{0, core.on_b - target.radius() * normal, -normal};
    if (!(approach > 0)) return std::nullopt;
    hit.position = core.on_b - target.radius() * normal + moved;
    hit.normal = -normal;
    hit.fraction += std::max(gap, 0.0) / approach;
    if (!(hit.fraction <= fraction_max)) return std::nullopt;
    if (gap <= kArrived * size) return hit;
  }
  return hit;
}

std::optional<ShapeHit> SweepToHalfSpace(const Solid& moving, const Vector3& translation, const Vector3& normal,
                                         double level) {
  const Proximity now = FromHalfSpace(normal, level, moving);
  const double fall = -normal.dot(translation);
  if (now.distance > 0 && !(fall >= now.distance)) return std::nullopt;
  const double fraction = now.distance > 0 ? now.distance / fall : 0;
  const Vector3 lowest = now.on_b + fraction * translation;
  return ShapeHit{fraction, lowest - (normal.dot(lowest) - level) * normal, normal};
}

// In the frame of the surface. Only from the front of a triangle is there something to hit.
std::optional<ShapeHit> SweepToSurface(const Shape& shape, const Placement& placement, const Vector3& translation,
                                       const Shape& surface) {
  const Proximity now = FromSurface(surface, shape, placement, 0);
  if (now.distance < 0) return ShapeHit{0, now.on_a, now.normal};
  const Solid moving(shape, placement);
  const Bounds start = BoundsOf(shape, placement);
  std::optional<ShapeHit> best;
  const auto fraction_max = [&] { return best ? best->fraction : 1; };
  const auto test = [&](const Bounds& box) {
    WorkWatch::Spend(kTriangleWork);
    const Vector3 way = fraction_max() * translation;
    return box.Overlaps(start.Union({start.min + way, start.max + way}));
  };
  const auto visit = [&](const SurfaceTriangle& triangle) {
    const Vector3 up = triangle.AreaVector();
    const bool is_behind = moving.Reach(up.normalized()) < up.normalized().dot(triangle.corners[0]);
    if (is_behind || !(up.dot(translation) < 0)) return;
    WorkWatch::Spend(kMeetingWork);
    const auto hit = Sweep(moving, translation, Solid(triangle), fraction_max());
    if (hit && (!best || hit->fraction < best->fraction)) best = hit;
  };
  if (const auto* mesh = std::get_if<TriangleMesh>(&surface)) VisitTriangles(*mesh->data, test, visit);
  if (const auto* field = std::get_if<Heightfield>(&surface)) VisitTriangles(*field->data, test, visit);
  return best;
}

}  // namespace

std::optional<Proximity> FindProximity(const Shape& a, const Placement& placement_a, const Shape& b,
                                       const Placement& placement_b, double within) {
  const bool is_turned = IsSurface(b) ? !IsSurface(a) : std::holds_alternative<Plane>(b) && IsConvex(a);
  Proximity found =
      is_turned ? Turned(Find(b, placement_b, a, placement_a, within)) : Find(a, placement_a, b, placement_b, within);
  // A search that found nothing nearer leaves no normal.
  if (!(found.distance <= within) || found.normal.isZero(0)) return std::nullopt;
  return found;
}

std::optional<ShapeHit> SweepShape(const Shape& shape, const Placement& placement, const Vector3& translation,
                                   const Shape& target, const Placement& target_placement) {
  std::optional<ShapeHit> hit;
  const Placement local = target_placement.ToLocal(placement);
  const Vector3 local_translation = target_placement.rotation.transpose() * translation;
  if (IsSurface(target)) {
    hit = SweepToSurface(shape, local, local_translation, target);
  } else if (const auto* plane = std::get_if<Plane>(&target)) {
    hit = SweepToHalfSpace(Solid(shape, local), local_translation, plane->normal, plane->offset);
  } else {
    hit = Sweep(Solid(shape, local), local_translation, Solid(target, {}), 1);
  }
  if (!hit) return std::nullopt;
  hit->position = target_placement.Transform(hit->position);
  hit->normal = target_placement.rotation * hit->normal;
  return hit;
}

}  // namespace genphys

#pragma once
#include <vector>

#include "genphys/narrow_phase.h"
#include "shapes/clipping.h"
#include "shapes/direction_index.h"

namespace genphys {

/// Gathers the points in which a convex solid meets a surface, one group for each direction in which that pushes.
class SurfacePoints {
 public:
  /// Points of `solid`, which must outlive this. Those with a larger gap (m) are left out.
  SurfacePoints(double gap, const Solid& solid);

  void Add(const PointSet& points);
  /// Whether there is a point that is no gap.
  bool HasOverlap() const;
  /// Whether there is a point as deep as this one in much the same direction, among those of the first directions.
  bool HasAsDeep(const MeetingPoint& point) const;
  /// Adds of `seams` what lies deeper than all points so far in much the same direction: beside those seams, where the
  /// solid comes nearer, a triangle was taken to be met by another one.
  void AddLacking(SurfacePoints& seams);
  /// Appends the groups with the deepest points, four points of each.
  void ReduceTo(Manifold& manifold);

 private:
  // Numbers of groups; in the order in which they came about.
  size_t GroupFor(const Vector3& normal);
  void SortGroups();
  PointSet InOrder(const PointSet& group) const;

  double gap_;
  const Solid& solid_;
  double same_;  // m: as near as this to one before, a point is no other
  std::vector<PointSet> groups_;
  DirectionIndex group_at_;  // by normal, once they are many
};

/// Where a mesh or heightfield meets the bounded convex `shape`, which lies at `placement` in the frame of the surface.
/// Positions and normals, from the surface to the shape, are in that frame too. The edges between two triangles push
/// only in directions between their normals, so that what slides over a flat seam does not feel it.
void FindSurfaceContacts(const Shape& surface, const Shape& shape, const Placement& placement, double gap,
                         Manifold& manifold);

/// Calls visit(triangle) for the triangles of `surface` within `bounds` in its frame until it returns false.
template <typename Visit>
void VisitTrianglesIn(const Shape& surface, const Bounds& bounds, Visit&& visit) {
  bool go_on = true;
  const auto test = [&](const Bounds& box) { return go_on && box.Overlaps(bounds); };
  const auto visit_triangle = [&](const SurfaceTriangle& triangle) {
    if (go_on) go_on = visit(triangle);
  };
  if (const auto* mesh = std::get_if<TriangleMesh>(&surface)) VisitTriangles(*mesh->data, test, visit_triangle);
  if (const auto* field = std::get_if<Heightfield>(&surface)) VisitTriangles(*field->data, test, visit_triangle);
}

}  // namespace genphys

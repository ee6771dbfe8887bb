#pragma once
#include "genphys/math.h"
#include "genphys/placement.h"
#include "genphys/shape.h"

namespace genphys {

/// Axis-aligned box, m. Its surface belongs to it.
struct Bounds {
  Vector3 min = Vector3::Zero();
  Vector3 max = Vector3::Zero();

  bool Overlaps(const Bounds& o) const {
    // Without short circuits: five branches that nobody can predict cost more than the comparisons.
    return (min.x() <= o.max.x()) & (o.min.x() <= max.x()) & (min.y() <= o.max.y()) & (o.min.y() <= max.y()) &
           (min.z() <= o.max.z()) & (o.min.z() <= max.z());
  }
  bool Contains(const Bounds& o) const {
    return (min.x() <= o.min.x()) & (o.max.x() <= max.x()) & (min.y() <= o.min.y()) & (o.max.y() <= max.y()) &
           (min.z() <= o.min.z()) & (o.max.z() <= max.z());
  }
  double HalfArea() const {
    const Vector3 d = max - min;
    return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
  }
  /// Of the distance between the two, m^2; zero if they overlap.
  double SquaredGap(const Bounds& o) const { return (min - o.max).cwiseMax(o.min - max).cwiseMax(0).squaredNorm(); }
  /// Larger by `margin` on every side.
  Bounds Widened(double margin) const { return {min.array() - margin, max.array() + margin}; }
  Bounds Shifted(const Vector3& by) const { return {min + by, max + by}; }
  Bounds Union(const Bounds& o) const { return {min.cwiseMin(o.min), max.cwiseMax(o.max)}; }
};

/// The smallest bounds of `shape` at `placement`; of a triangle mesh, a heightfield or a hull of many vertices those of
/// its own box there, of a heightfield as deep as it is wide. A plane is unbounded: infinite.
Bounds BoundsOf(const Shape& shape, const Placement& placement);

/// From the origin of its frame to the farthest point of `shape`, m; infinite for a plane.
double BoundingRadius(const Shape& shape);

/// Half of the least width of `shape`, or something near it: the scale of its finest part, m. Of a plane infinite, of a
/// surface the cell size or a tenth of its extent.
double SmallestHalfExtent(const Shape& shape);

}  // namespace genphys

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
    return (min.array() <= o.max.array()).all() && (o.min.array() <= max.array()).all();
  }
  /// Larger by `margin` on every side.
  Bounds Widened(double margin) const { return {min.array() - margin, max.array() + margin}; }
  Bounds Union(const Bounds& o) const { return {min.cwiseMin(o.min), max.cwiseMax(o.max)}; }
};

/// The smallest bounds of `shape` at `placement`; of a triangle mesh, a heightfield or a hull of many vertices those of
/// its own box there, of a heightfield as deep as it is wide. A plane is unbounded: infinite.
Bounds BoundsOf(const Shape& shape, const Placement& placement);

/// Half of the least width of `shape`, or something near it: the scale of its finest part, m. Of a plane infinite, of a
/// surface the cell size or a tenth of its extent.
double SmallestHalfExtent(const Shape& shape);

}  // namespace genphys

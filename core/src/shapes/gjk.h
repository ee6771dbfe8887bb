#pragma once
#include <limits>
#include <optional>

#include "shapes/simplex.h"
#include "shapes/solid.h"

namespace genphys {

/// Closest points of the cores of two solids.
struct CorePoints {
  Vector3 on_a = Vector3::Zero();
  Vector3 on_b = Vector3::Zero();
  Vector3 normal = Vector3::Zero();  // unit length, from a to b; zero if they overlap
  double distance = 0;               // along the normal, m; zero if they overlap
};

/// What FindCorePoints() is asked for.
struct CoreQuery {
  Vector3 shift = Vector3::Zero();  // m, by which b is moved
  double nothing = 0;               // m: solids that are nearer to each other overlap
  double shrink = 0;                // by this part both are first made smaller about their centres
  double distance_max = std::numeric_limits<double>::infinity();  // m: of what is farther apart only that is told
  double tolerance = 1e-13;                                       // of the squared distance
  std::optional<Vector3> direction{};  // from a to b, along which they are thought to be nearest

  /// Where a point of a solid is on its smaller copy, and the other way round.
  Vector3 Shrunk(const Solid& solid, const Vector3& point) const { return point + shrink * (solid.center() - point); }
  Vector3 Unshrunk(const Solid& solid, const Vector3& point) const {
    return (point - shrink * solid.center()) / (1 - shrink);
  }
};

/// Where the difference of `a` and `b` is closest to the origin (E. G. Gilbert, D. W. Johnson and S. S. Keerthi, 1988).
/// Between polyhedra it ends at the exact points up to rounding, unless the tolerance ends it before.
Nearest FindNearest(const Solid& a, const Solid& b, const CoreQuery& query);

/// The closest points of `a` and `b` that make that up.
CorePoints FindCorePoints(const Solid& a, const Solid& b, const CoreQuery& query);

}  // namespace genphys

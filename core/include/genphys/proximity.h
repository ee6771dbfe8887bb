#pragma once
#include <limits>
#include <optional>

#include "genphys/placement.h"
#include "genphys/shape.h"

namespace genphys {

/// How near two shapes are to each other.
struct Proximity {
  double distance = std::numeric_limits<double>::infinity();  // m; negative: how deep they overlap
  Vector3 on_a = Vector3::Zero();                             // the closest point of a
  Vector3 on_b = Vector3::Zero();                             // the closest point of b
  Vector3 normal = Vector3::Zero();                           // unit length, from a to b
};

/// The closest points of `a` and `b` at these placements, or nothing if they are farther apart than `within` (m). What
/// lies behind a triangle of a mesh is as near to it as what lies before it; all straight below a heightfield is in it.
/// Two planes that are not parallel and apart overlap infinitely deep, which is told as a distance of zero.
std::optional<Proximity> FindProximity(const Shape& a, const Placement& placement_a, const Shape& b,
                                       const Placement& placement_b,
                                       double within = std::numeric_limits<double>::infinity());

/// Where a moving shape meets another one first.
struct ShapeHit {
  double fraction = 0;                 // 0 to 1 along the translation
  Vector3 position = Vector3::Zero();  // on the surface that was hit
  Vector3 normal = Vector3::Zero();    // out of that surface, unit length
};

/// Where the bounded convex `shape` meets `target` first on its way along `translation` (m), without turning. What it
/// overlaps already is met at the fraction 0. Exact for polyhedra and planes, to 1e-9 of the smaller size for others.
std::optional<ShapeHit> SweepShape(const Shape& shape, const Placement& placement, const Vector3& translation,
                                   const Shape& target, const Placement& target_placement);

}  // namespace genphys

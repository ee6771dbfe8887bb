#pragma once
#include "shapes/solid.h"

namespace genphys {

/// Closest points of the cores of two solids.
struct CorePoints {
  Vector3 on_a = Vector3::Zero();
  Vector3 on_b = Vector3::Zero();
  Vector3 normal = Vector3::Zero();  // unit length, from a to b; zero if they overlap
  double distance = 0;               // along the normal, m; zero if they overlap
};

/// Closest points of `a` and of `b` moved by `shift` (E. G. Gilbert, D. W. Johnson and S. S. Keerthi, 1988). Between
/// polyhedra it ends at the exact points up to rounding, round solids after the distance is known to 1e-13 of it. With
/// `shrink` both are first made smaller by this part about their centres. Solids that are nearer to each other than
/// `nothing` (m) overlap.
CorePoints FindCorePoints(const Solid& a, const Solid& b, const Vector3& shift, double nothing, double shrink = 0);

}  // namespace genphys

#pragma once
#include "genphys/placement.h"
#include "shapes/clipping.h"

namespace genphys {

/// Adds the points in which two boxes meet. Of the directions that part them about as soon the same one is taken each
/// time, so that points do not jump about from step to step: a face of `a` before one of `b`, either before a pair of
/// edges. Returns false where corners or edges that are closest lie beside each other: their direction is none of
/// these, and is to be searched as that of any other solids, without the points.
/// Directions: S. Gottschalk, M. C. Lin and D. Manocha, "OBBTree", SIGGRAPH 1996 (separating axes).
bool AddBoxPoints(const Box& a, const Placement& placement_a, const Box& b, const Placement& placement_b, double gap,
                  PointSet& points);

}  // namespace genphys

#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "genphys/math.h"

namespace genphys {

/// Numbers of points, anticlockwise as seen from outside.
using HullTriangle = std::array<uint32_t, 3>;

/// The convex hull of `points` (which are about 1 in extent and not all near one plane) as a closed surface of
/// triangles, some of which may be thin or without area. Empty if there is none.
std::vector<HullTriangle> HullTriangles(const std::vector<Vector3>& points);

}  // namespace genphys

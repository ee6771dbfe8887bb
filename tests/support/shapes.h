#pragma once
#include <functional>

#include "genphys/convex_hull.h"
#include "genphys/surface.h"

namespace genphys::testing {

/// The hull of the corners of a box, turned by `turn` about its middle.
ConvexHull HullBox(const Vector3& half_extents, const Quaternion& turn = Quaternion::Identity());

/// A mesh over the square of side 2 * `half_side` m about the origin, of 2 * `cells`^2 triangles.
TriangleMesh GroundMesh(
    double half_side, int cells,
    const std::function<double(double x, double y)>& height = [](double, double) { return 0.0; });

/// The surface of a box as a closed mesh.
TriangleMesh BoxMesh(const Vector3& half_extents);

/// A square heightfield of `points`^2 grid points.
Heightfield Ground(
    uint32_t points, double cell_size,
    const std::function<double(double x, double y)>& height = [](double, double) { return 0.0; });

}  // namespace genphys::testing

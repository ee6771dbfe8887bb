#include "support/shapes.h"

#include <gtest/gtest.h>

#include <utility>

namespace genphys::testing {
namespace {

template <typename T>
T Must(Result<T> made) {
  EXPECT_TRUE(made.ok()) << made.status();
  return made.ok() ? *std::move(made) : T{};
}

std::vector<Vector3> CornersOf(const Vector3& half_extents) {
  std::vector<Vector3> corners;
  for (int i = 0; i < 8; ++i) {
    corners.push_back(Vector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1).cwiseProduct(half_extents));
  }
  return corners;
}

}  // namespace

ConvexHull HullBox(const Vector3& half_extents, const Quaternion& turn) {
  std::vector<Vector3> corners = CornersOf(half_extents);
  for (Vector3& corner : corners) corner = turn * corner;
  return Must(MakeConvexHull(corners));
}

TriangleMesh GroundMesh(double half_side, int cells, const std::function<double(double x, double y)>& height) {
  std::vector<Vector3> vertices;
  std::vector<uint32_t> indices;
  const auto row = static_cast<uint32_t>(cells) + 1;
  for (int i = 0; i <= cells; ++i) {
    for (int j = 0; j <= cells; ++j) {
      const double x = half_side * (2.0 * j / cells - 1), y = half_side * (2.0 * i / cells - 1);
      vertices.push_back({x, y, height(x, y)});
      if (i == cells || j == cells) continue;
      const auto corner = static_cast<uint32_t>(i) * row + static_cast<uint32_t>(j);
      indices.insert(indices.end(), {corner, corner + 1, corner + row + 1, corner, corner + row + 1, corner + row});
    }
  }
  return Must(MakeTriangleMesh(vertices, indices));
}

TriangleMesh BoxMesh(const Vector3& half_extents) {
  // Of each face the corners anticlockwise as seen from outside.
  static constexpr uint32_t kFaces[6][4]{{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  std::vector<uint32_t> indices;
  for (const auto& [a, b, c, d] : kFaces) indices.insert(indices.end(), {a, b, c, a, c, d});
  return Must(MakeTriangleMesh(CornersOf(half_extents), indices));
}

Heightfield Ground(uint32_t points, double cell_size, const std::function<double(double x, double y)>& height) {
  std::vector<double> heights;
  for (uint32_t r = 0; r < points; ++r) {
    for (uint32_t c = 0; c < points; ++c) {
      heights.push_back(height((c - (points - 1) / 2.0) * cell_size, (r - (points - 1) / 2.0) * cell_size));
    }
  }
  return Must(MakeHeightfield(points, points, cell_size, heights));
}

}  // namespace genphys::testing

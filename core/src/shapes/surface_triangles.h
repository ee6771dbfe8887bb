#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "genphys/surface.h"
#include "genphys/work_watch.h"

namespace genphys {

/// One triangle of a surface, in its frame, anticlockwise as seen from the empty side.
struct SurfaceTriangle {
  std::array<Vector3, 3> corners;
  std::array<uint32_t, 3> numbers{};  // of vertices of a mesh, of grid points of a heightfield
  uint32_t place = 0;                 // of a mesh, among its triangles

  Vector3 AreaVector() const { return (corners[1] - corners[0]).cross(corners[2] - corners[0]); }
};

/// Of a WorkWatch, to look at one, or for those in some bounds.
inline constexpr int64_t kTriangleWork = 32;

/// Calls visit(triangle) for the triangles in whose bounds `test` is interested, in an order that is the same each
/// time.
template <typename Test, typename Visit>
void VisitTriangles(const MeshData& mesh, Test&& test, Visit&& visit, uint32_t root = 0) {
  const MeshData::Node& node = mesh.nodes[root];
  if (!test(node.bounds)) return;
  if (node.count == 0) {
    VisitTriangles(mesh, test, visit, root + 1);
    VisitTriangles(mesh, test, visit, node.first);
    return;
  }
  for (uint32_t i = node.first; i < node.first + node.count; ++i) {
    const MeshData::Triangle& t = mesh.triangles[i];
    visit(SurfaceTriangle{{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, t, i});
  }
}

/// A square block of cells of a heightfield: 2^level cells wide, at the given place among such blocks.
struct HeightfieldBlock {
  size_t level = 0;
  uint32_t row = 0;
  uint32_t column = 0;
};

Bounds BoundsOf(const HeightfieldData& field, const HeightfieldBlock& block);

/// The two triangles of a cell.
std::array<SurfaceTriangle, 2> TrianglesOf(const HeightfieldData& field, uint32_t row, uint32_t column);

/// Calls visit(part) for the parts of a block that are on the field, at most four.
template <typename Visit>
void VisitParts(const HeightfieldData& field, const HeightfieldBlock& block, Visit&& visit) {
  for (const auto& [down, across] : {std::pair{0u, 0u}, {0u, 1u}, {1u, 0u}, {1u, 1u}}) {
    const HeightfieldBlock part{block.level - 1, 2 * block.row + down, 2 * block.column + across};
    if (part.row << part.level < field.rows - 1 && part.column << part.level < field.columns - 1) visit(part);
  }
}

template <typename Test, typename Visit>
void VisitTriangles(const HeightfieldData& field, Test&& test, Visit&& visit, const HeightfieldBlock& block) {
  if (!test(BoundsOf(field, block))) return;
  if (block.level == 0) {
    for (const SurfaceTriangle& triangle : TrianglesOf(field, block.row, block.column)) visit(triangle);
    return;
  }
  VisitParts(field, block, [&](const HeightfieldBlock& part) { VisitTriangles(field, test, visit, part); });
}

template <typename Test, typename Visit>
void VisitTriangles(const HeightfieldData& field, Test&& test, Visit&& visit) {
  VisitTriangles(field, test, visit, HeightfieldBlock{field.levels.size() - 1, 0, 0});
}

/// Whether something in bounds so far apart (m^2) may be nearer than `within` m, or overlap what overlaps already.
inline bool MayBeNearer(double squared_gap, double within) {
  return squared_gap == 0 || (within > 0 && squared_gap < within * within);
}

/// Calls visit(triangle) for the triangles in bounds that MayBeNearer() than `within` to `bounds`, in an order that is
/// the same each time. The nearer part comes first, and visit() may lower `within`.
template <typename Visit>
void VisitNearTriangles(const MeshData& mesh, const Bounds& bounds, const double& within, Visit&& visit,
                        uint32_t root = 0) {
  const MeshData::Node& node = mesh.nodes[root];
  WorkWatch::Spend(kTriangleWork);
  if (node.count > 0) {
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      const MeshData::Triangle& t = mesh.triangles[i];
      visit(SurfaceTriangle{{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, t, i});
    }
    return;
  }
  const auto gap_and_part = [&](uint32_t part) { return std::pair(mesh.nodes[part].bounds.SquaredGap(bounds), part); };
  std::array parts{gap_and_part(root + 1), gap_and_part(node.first)};
  if (parts[1].first < parts[0].first) std::swap(parts[0], parts[1]);
  for (const auto& [squared_gap, part] : parts) {
    if (MayBeNearer(squared_gap, within)) VisitNearTriangles(mesh, bounds, within, visit, part);
  }
}

template <typename Visit>
void VisitNearTriangles(const HeightfieldData& field, const Bounds& bounds, const double& within, Visit&& visit,
                        const HeightfieldBlock& block) {
  WorkWatch::Spend(kTriangleWork);
  if (block.level == 0) {
    for (const SurfaceTriangle& triangle : TrianglesOf(field, block.row, block.column)) visit(triangle);
    return;
  }
  std::array<std::pair<double, HeightfieldBlock>, 4> parts;
  size_t count = 0;
  VisitParts(field, block, [&](const HeightfieldBlock& part) {
    const double squared_gap = BoundsOf(field, part).SquaredGap(bounds);
    size_t place = count++;
    for (; place > 0 && squared_gap < parts[place - 1].first; --place) parts[place] = parts[place - 1];
    parts[place] = {squared_gap, part};
  });
  for (const auto& [squared_gap, part] : std::span(parts).first(count)) {
    if (MayBeNearer(squared_gap, within)) VisitNearTriangles(field, bounds, within, visit, part);
  }
}

template <typename Visit>
void VisitNearTriangles(const HeightfieldData& field, const Bounds& bounds, const double& within, Visit&& visit) {
  VisitNearTriangles(field, bounds, within, visit, HeightfieldBlock{field.levels.size() - 1, 0, 0});
}

/// Calls visit(vertex) for every vertex that shares an edge with vertex `number`.
template <typename Visit>
void VisitNeighbors(const MeshData& mesh, uint32_t number, Visit&& visit) {
  WorkWatch::Look(mesh.neighbor_first[number + 1] - mesh.neighbor_first[number]);
  for (uint32_t i = mesh.neighbor_first[number]; i < mesh.neighbor_first[number + 1]; ++i) {
    visit(mesh.vertices[mesh.neighbors[i]]);
  }
}

template <typename Visit>
void VisitNeighbors(const HeightfieldData& field, uint32_t number, Visit&& visit) {
  const auto row = static_cast<int64_t>(number / field.columns), column = static_cast<int64_t>(number % field.columns);
  for (const auto& [down, across] : {std::pair{-1, -1}, {-1, 0}, {0, -1}, {0, 1}, {1, 0}, {1, 1}}) {
    const int64_t r = row + down, c = column + across;
    if (r < 0 || c < 0 || r >= field.rows || c >= field.columns) continue;
    visit(field.Point(static_cast<uint32_t>(r), static_cast<uint32_t>(c)));
  }
}

/// The third corner of the triangle beyond the edge from corner `k` of `triangle` to the next; none where the surface
/// ends or goes on in more ways than one.
std::optional<Vector3> Across(const MeshData& mesh, const SurfaceTriangle& triangle, size_t k);
std::optional<Vector3> Across(const HeightfieldData& field, const SurfaceTriangle& triangle, size_t k);

/// Calls visit(vertex) for the third corner of the triangle beyond that edge; where the surface goes on in more ways
/// than one, for every vertex that shares an edge with both ends.
template <typename Visit>
void VisitAcross(const MeshData& mesh, const SurfaceTriangle& triangle, size_t k, Visit&& visit) {
  if (const std::optional<Vector3> across = Across(mesh, triangle, k)) return visit(*across);
  const auto neighbors_of = [&](size_t i) {
    const uint32_t number = triangle.numbers[i % 3];
    WorkWatch::Look(mesh.neighbor_first[number + 1] - mesh.neighbor_first[number]);
    return std::span(mesh.neighbors)
        .subspan(mesh.neighbor_first[number], mesh.neighbor_first[number + 1] - mesh.neighbor_first[number]);
  };
  const std::span<const uint32_t> others = neighbors_of(k + 1);
  for (const uint32_t neighbor : neighbors_of(k)) {
    if (std::ranges::binary_search(others, neighbor)) visit(mesh.vertices[neighbor]);
  }
}

template <typename Visit>
void VisitAcross(const HeightfieldData& field, const SurfaceTriangle& triangle, size_t k, Visit&& visit) {
  if (const std::optional<Vector3> across = Across(field, triangle, k)) visit(*across);
}

/// Whether the surface ends at vertex `number`.
inline bool IsAtRim(const MeshData& mesh, uint32_t number) { return mesh.is_at_rim[number] != 0; }
inline bool IsAtRim(const HeightfieldData& field, uint32_t number) {
  const uint32_t row = number / field.columns, column = number % field.columns;
  return row == 0 || column == 0 || row + 1 == field.rows || column + 1 == field.columns;
}

/// The bounds of the whole surface.
inline Bounds BoundsOf(const MeshData& mesh) { return mesh.nodes.front().bounds; }
inline Bounds BoundsOf(const HeightfieldData& field) { return BoundsOf(field, {field.levels.size() - 1, 0, 0}); }

}  // namespace genphys

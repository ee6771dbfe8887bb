#include "shapes/surface_triangles.h"

#include <algorithm>

namespace genphys {

Bounds BoundsOf(const HeightfieldData& field, const HeightfieldBlock& block) {
  const uint32_t size = 1u << block.level;
  const uint32_t blocks_across = (field.columns - 1 + size - 1) / size;
  const HeightfieldData::Range& range = field.levels[block.level][size_t{block.row} * blocks_across + block.column];
  const uint32_t row = block.row * size, column = block.column * size;
  Bounds bounds{field.Point(row, column),
                field.Point(std::min(row + size, field.rows - 1), std::min(column + size, field.columns - 1))};
  bounds.min.z() = range.low;
  bounds.max.z() = range.high;
  return bounds;
}

std::array<SurfaceTriangle, 2> TrianglesOf(const HeightfieldData& field, uint32_t row, uint32_t column) {
  const uint32_t here = row * field.columns + column, above = here + field.columns;
  const Vector3 low = field.Point(row, column), high = field.Point(row + 1, column + 1);
  return {SurfaceTriangle{{low, field.Point(row, column + 1), high}, {here, here + 1, above + 1}},
          SurfaceTriangle{{low, high, field.Point(row + 1, column)}, {here, above + 1, above}}};
}

std::optional<Vector3> Across(const MeshData& mesh, const SurfaceTriangle& triangle, size_t k) {
  const uint32_t across = mesh.across[triangle.place][k];
  if (across == MeshData::kNone) return std::nullopt;
  return mesh.vertices[across];
}

// Two triangles on one edge are halves of a parallelogram on the grid.
std::optional<Vector3> Across(const HeightfieldData& field, const SurfaceTriangle& triangle, size_t k) {
  const auto along = [&](auto part) {
    const auto of = [&](size_t i) { return static_cast<int64_t>(part(triangle.numbers[i % 3])); };
    return of(k) + of(k + 1) - of(k + 2);
  };
  const int64_t row = along([&](uint32_t number) { return number / field.columns; });
  const int64_t column = along([&](uint32_t number) { return number % field.columns; });
  if (row < 0 || column < 0 || row >= field.rows || column >= field.columns) return std::nullopt;
  return field.Point(static_cast<uint32_t>(row), static_cast<uint32_t>(column));
}

}  // namespace genphys

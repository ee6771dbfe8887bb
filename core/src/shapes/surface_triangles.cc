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

}  // namespace genphys

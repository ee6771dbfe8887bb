#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "genphys/bounds.h"
#include "genphys/math.h"
#include "genphys/shape.h"
#include "genphys/status.h"

namespace genphys {

/// A triangle mesh made ready, shared by all copies of a TriangleMesh.
struct MeshData {
  static constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
  using Triangle = std::array<uint32_t, 3>;  // numbers of corners, anticlockwise as seen from the empty side

  struct Node {
    Bounds bounds;
    uint32_t first = 0;  // leaf: of its triangles; else: its second child, the first one follows it
    uint32_t count = 0;  // of triangles; zero: no leaf
  };

  std::vector<Vector3> vertices;  // as asked for, m
  std::vector<uint32_t> indices;  // as asked for

  // Without triangles that repeat others or have no area, vertices at one place made one, in the order of the tree.
  std::vector<Triangle> triangles;
  std::vector<Node> nodes;  // the root first
  // Vertices that share an edge with vertex v: entries neighbor_first[v] to neighbor_first[v + 1].
  std::vector<uint32_t> neighbor_first;
  std::vector<uint32_t> neighbors;
  std::vector<uint8_t> is_at_rim;  // by vertex: on an edge beyond which no triangle of the same side goes on
  // By triangle: the third corner of the one beyond the edge from its corner k to the next, kNone if there is no such
  // or more than one.
  std::vector<Triangle> across;
  uint64_t hash = 0;  // of vertices and indices
};

/// A mesh of `vertices` (m) and three numbers of them per triangle. Triangles without area and repeated ones are left
/// out. Refuses, at "vertices" or "indices[i]": what is not finite or outside the limits, numbers of no vertex, and a
/// mesh of which no triangle is left.
Result<TriangleMesh> MakeTriangleMesh(std::vector<Vector3> vertices, std::vector<uint32_t> indices);

/// Heights over a grid, shared by all copies of a Heightfield. The grid point in row r and column c lies at
/// x = (c - (columns - 1) / 2) * cell_size and y = (r - (rows - 1) / 2) * cell_size; each cell is two triangles that
/// meet between its corners of lowest and of highest x and y.
struct HeightfieldData {
  struct Range {
    double low = 0;
    double high = 0;
  };

  uint32_t rows = 0;
  uint32_t columns = 0;
  double cell_size = 0;         // m
  std::vector<double> heights;  // row by row, m
  // Lowest and highest height in blocks of 2^level x 2^level cells, row by row, from level 0 on.
  std::vector<std::vector<Range>> levels;
  uint64_t hash = 0;  // of all of the above that was asked for

  Vector3 Point(uint32_t row, uint32_t column) const {
    return {(column - (columns - 1) / 2.0) * cell_size, (row - (rows - 1) / 2.0) * cell_size,
            heights[size_t{row} * columns + column]};
  }
};

/// Refuses, at "rows", "columns", "cell_size" or "heights", what is not finite or outside the limits, and heights that
/// are not rows * columns in number.
Result<Heightfield> MakeHeightfield(uint32_t rows, uint32_t columns, double cell_size, std::vector<double> heights);

/// About how many bytes the data of a hull, mesh or heightfield takes, which its copies share; none for other shapes.
size_t DataBytesOf(const Shape& shape);

}  // namespace genphys

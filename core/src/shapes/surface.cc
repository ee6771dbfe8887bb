#include "genphys/surface.h"

#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "genphys/convex_hull.h"
#include "genphys/limits.h"
#include "genphys/work_watch.h"
#include "model/cat.h"
#include "model/validate.h"

namespace genphys {
namespace {

// Of a WorkWatch, for a corner of what is described.
constexpr int64_t kPointWork = 100;

// Height of a triangle over its longest side, in parts of that, below which it has no area.
constexpr double kFlatTriangle = 1e-10;
constexpr uint32_t kLeafTriangles = 4;

using Triangle = MeshData::Triangle;

uint64_t Hash(const void* data, size_t size, uint64_t seed) { return XXH3_64bits_withSeed(data, size, seed); }

// For each vertex the first one at the same place.
std::vector<uint32_t> Welded(const std::vector<Vector3>& vertices) {
  std::vector<uint32_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](uint32_t i) { return std::tuple(vertices[i].x(), vertices[i].y(), vertices[i].z()); };
  std::sort(order.begin(), order.end(),
            [&](uint32_t a, uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
  std::vector<uint32_t> first(vertices.size());
  for (size_t i = 0; i < order.size(); ++i) {
    const bool is_same = i > 0 && key(order[i]) == key(order[i - 1]);
    first[order[i]] = is_same ? first[order[i - 1]] : order[i];
  }
  return first;
}

bool HasArea(const MeshData& mesh, const Triangle& t) {
  const Vector3 a = mesh.vertices[t[1]] - mesh.vertices[t[0]], b = mesh.vertices[t[2]] - mesh.vertices[t[0]];
  const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()});
  return a.cross(b).norm() > kFlatTriangle * longest;
}

// The same triangle with its smallest number first.
Triangle Turned(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

void TakeTriangles(MeshData& mesh) {
  const std::vector<uint32_t> welded = Welded(mesh.vertices);
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const Triangle t{welded[mesh.indices[i]], welded[mesh.indices[i + 1]], welded[mesh.indices[i + 2]]};
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0] || !HasArea(mesh, t)) continue;
    mesh.triangles.push_back(Turned(t));
  }
  std::sort(mesh.triangles.begin(), mesh.triangles.end());
  mesh.triangles.erase(std::unique(mesh.triangles.begin(), mesh.triangles.end()), mesh.triangles.end());
}

void FindNeighbors(MeshData& mesh) {
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  edges.reserve(6 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    for (size_t k = 0; k < 3; ++k) edges.push_back({t[k], t[(k + 1) % 3]});
  }
  std::sort(edges.begin(), edges.end());
  mesh.is_at_rim.assign(mesh.vertices.size(), 0);
  const size_t directed = edges.size();
  for (size_t i = 0; i < directed; ++i) {
    const auto [from, to] = edges[i];
    // Each edge is walked once in either direction, or the surface does not go on behind it.
    const auto back =
        std::equal_range(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(directed), std::pair(to, from));
    if (back.second - back.first != 1) mesh.is_at_rim[from] = mesh.is_at_rim[to] = 1;
  }
  for (size_t i = 0; i < directed; ++i) edges.push_back({edges[i].second, edges[i].first});
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  mesh.neighbor_first.assign(mesh.vertices.size() + 1, 0);
  mesh.neighbors.reserve(edges.size());
  for (const auto& [from, to] : edges) {
    ++mesh.neighbor_first[from + 1];
    mesh.neighbors.push_back(to);
  }
  std::partial_sum(mesh.neighbor_first.begin(), mesh.neighbor_first.end(), mesh.neighbor_first.begin());
}

// What lies beyond the edges of the triangles, in their order.
void FindAcross(MeshData& mesh) {
  struct Edge {
    std::array<uint32_t, 2> ends;
    uint32_t third;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    for (size_t k = 0; k < 3; ++k) edges.push_back({{t[k], t[(k + 1) % 3]}, t[(k + 2) % 3]});
  }
  std::ranges::sort(edges, {}, &Edge::ends);
  const auto only = [&](uint32_t from, uint32_t to) {
    const auto found = std::ranges::equal_range(edges, std::array{from, to}, {}, &Edge::ends);
    return found.size() == 1 ? found.front().third : MeshData::kNone;
  };
  mesh.across.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    Triangle& across = mesh.across.emplace_back();
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t from = t[k], to = t[(k + 1) % 3];
      across[k] = only(from, to) != MeshData::kNone ? only(to, from) : MeshData::kNone;
    }
  }
}

// A tree over `triangles`, halved at the median of their middles along the widest axis.
class TreeMaker {
 public:
  explicit TreeMaker(MeshData& mesh) : mesh_(mesh) {
    order_.resize(mesh.triangles.size());
    std::iota(order_.begin(), order_.end(), 0);
    middles_.reserve(order_.size());
    for (const Triangle& t : mesh.triangles) middles_.push_back(BoundsOf(t).min + BoundsOf(t).max);
    mesh.nodes.reserve(order_.size());
    Make(0, static_cast<uint32_t>(order_.size()));
    std::vector<Triangle> sorted;
    sorted.reserve(order_.size());
    for (const uint32_t i : order_) sorted.push_back(mesh.triangles[i]);
    mesh.triangles = std::move(sorted);
  }

 private:
  Bounds BoundsOf(const Triangle& t) const {
    const Vector3 &a = mesh_.vertices[t[0]], &b = mesh_.vertices[t[1]], &c = mesh_.vertices[t[2]];
    return {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
  }

  void Make(uint32_t begin, uint32_t end) {
    const size_t node = mesh_.nodes.size();
    mesh_.nodes.emplace_back();
    Bounds bounds = BoundsOf(mesh_.triangles[order_[begin]]);
    Bounds middles{middles_[order_[begin]], middles_[order_[begin]]};
    for (uint32_t i = begin + 1; i < end; ++i) {
      bounds = bounds.Union(BoundsOf(mesh_.triangles[order_[i]]));
      middles = middles.Union({middles_[order_[i]], middles_[order_[i]]});
    }
    mesh_.nodes[node].bounds = bounds;
    if (end - begin <= kLeafTriangles) {
      mesh_.nodes[node].first = begin;
      mesh_.nodes[node].count = end - begin;
      return;
    }
    int axis = 0;
    (middles.max - middles.min).maxCoeff(&axis);
    const uint32_t half = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end, [&](uint32_t a, uint32_t b) {
      return std::pair(middles_[a][axis], a) < std::pair(middles_[b][axis], b);
    });
    Make(begin, half);
    mesh_.nodes[node].first = static_cast<uint32_t>(mesh_.nodes.size());
    Make(half, end);
  }

  MeshData& mesh_;
  std::vector<uint32_t> order_;
  std::vector<Vector3> middles_;
};

Status CheckMesh(const std::vector<Vector3>& vertices, const std::vector<uint32_t>& indices) {
  if (vertices.empty()) return Refuse(Reason::kMissingField, "vertices", "a mesh has vertices");
  for (size_t i = 0; i < vertices.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      if (std::abs(vertices[i][k]) <= Limits::kSizeMax) continue;
      return CheckNumber(vertices[i][k], -Limits::kSizeMax, Limits::kSizeMax,
                         Cat("vertices[", 3 * i + static_cast<size_t>(k), "]"));
    }
  }
  if (indices.empty()) return Refuse(Reason::kMissingField, "indices", "a mesh has triangles");
  if (indices.size() % 3 != 0) {
    return Refuse(Reason::kInvalidValue, "indices", "a mesh has three numbers for each triangle");
  }
  for (size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] < vertices.size()) continue;
    return Refuse(Reason::kOutOfRange, Cat("indices[", i, "]"),
                  Cat("there is no vertex ", indices[i], " among ", vertices.size()));
  }
  return absl::OkStatus();
}

Status CheckHeights(uint32_t rows, uint32_t columns, double cell_size, const std::vector<double>& heights) {
  GENPHYS_RETURN_IF_ERROR(CheckNumber(rows, 2, Limits::kHeightfieldSideMax, "rows"));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(columns, 2, Limits::kHeightfieldSideMax, "columns"));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(cell_size, Limits::kSizeMin, Limits::kSizeMax, "cell_size"));
  if (heights.size() != size_t{rows} * columns) {
    return Refuse(Reason::kInvalidValue, "heights",
                  Cat("there are ", heights.size(), " heights for ", rows, " rows of ", columns));
  }
  for (size_t i = 0; i < heights.size(); ++i) {
    if (std::abs(heights[i]) <= Limits::kSizeMax) continue;
    return CheckNumber(heights[i], -Limits::kSizeMax, Limits::kSizeMax, Cat("heights[", i, "]"));
  }
  return absl::OkStatus();
}

using Range = HeightfieldData::Range;

Range Union(const Range& a, const Range& b) { return {std::min(a.low, b.low), std::max(a.high, b.high)}; }

void MakeLevels(HeightfieldData& field) {
  uint32_t rows = field.rows - 1, columns = field.columns - 1;
  std::vector<Range> cells;
  cells.reserve(size_t{rows} * columns);
  for (uint32_t r = 0; r < rows; ++r) {
    for (uint32_t c = 0; c < columns; ++c) {
      const auto height = [&](uint32_t row, uint32_t column) {
        return field.heights[size_t{row} * field.columns + column];
      };
      const auto [low, high] = std::minmax({height(r, c), height(r, c + 1), height(r + 1, c), height(r + 1, c + 1)});
      cells.push_back({low, high});
    }
  }
  field.levels.push_back(std::move(cells));
  while (rows > 1 || columns > 1) {
    const std::vector<Range>& finer = field.levels.back();
    const uint32_t half_rows = (rows + 1) / 2, half_columns = (columns + 1) / 2;
    std::vector<Range> coarser(size_t{half_rows} * half_columns);
    for (uint32_t r = 0; r < half_rows; ++r) {
      for (uint32_t c = 0; c < half_columns; ++c) {
        const uint32_t row = std::min(2 * r + 1, rows - 1), column = std::min(2 * c + 1, columns - 1);
        const auto at = [&](uint32_t y, uint32_t x) { return finer[size_t{y} * columns + x]; };
        coarser[size_t{r} * half_columns + c] =
            Union(Union(at(2 * r, 2 * c), at(2 * r, column)), Union(at(row, 2 * c), at(row, column)));
      }
    }
    field.levels.push_back(std::move(coarser));
    rows = half_rows;
    columns = half_columns;
  }
}

}  // namespace

size_t DataBytesOf(const Shape& shape) {
  if (const auto* hull = std::get_if<ConvexHull>(&shape); hull != nullptr && hull->data != nullptr) {
    const HullData& data = *hull->data;
    const size_t numbers =
        data.face_corners.size() + 2 * data.vertices.size() + data.neighbors.size() + data.vertex_faces.size();
    return (data.points.size() + data.vertices.size()) * sizeof(Vector3) + data.faces.size() * sizeof(HullData::Face) +
           numbers * sizeof(uint32_t);
  }
  if (const auto* mesh = std::get_if<TriangleMesh>(&shape); mesh != nullptr && mesh->data != nullptr) {
    const MeshData& data = *mesh->data;
    const size_t numbers = data.indices.size() + data.neighbor_first.size() + data.neighbors.size();
    return data.vertices.size() * sizeof(Vector3) + data.nodes.size() * sizeof(MeshData::Node) +
           2 * data.triangles.size() * sizeof(MeshData::Triangle) + numbers * sizeof(uint32_t);
  }
  if (const auto* field = std::get_if<Heightfield>(&shape); field != nullptr && field->data != nullptr) {
    // Each level has a quarter of the blocks of the one before.
    return field->data->heights.size() * (sizeof(double) + 2 * sizeof(HeightfieldData::Range));
  }
  return 0;
}

bool TriangleMesh::operator==(const TriangleMesh& o) const {
  if (data == o.data || data == nullptr || o.data == nullptr) return data == o.data;
  return data->hash == o.data->hash && data->vertices == o.data->vertices && data->indices == o.data->indices;
}

bool Heightfield::operator==(const Heightfield& o) const {
  if (data == o.data || data == nullptr || o.data == nullptr) return data == o.data;
  return data->hash == o.data->hash && data->rows == o.data->rows && data->columns == o.data->columns &&
         data->cell_size == o.data->cell_size && data->heights == o.data->heights;
}

Result<TriangleMesh> MakeTriangleMesh(std::vector<Vector3> vertices, std::vector<uint32_t> indices) {
  GENPHYS_RETURN_IF_ERROR(CheckMesh(vertices, indices));
  WorkWatch::Spend(kPointWork * static_cast<int64_t>(indices.size()));
  auto mesh = std::make_shared<MeshData>();
  mesh->vertices = std::move(vertices);
  mesh->indices = std::move(indices);
  mesh->hash = Hash(mesh->indices.data(), mesh->indices.size() * sizeof(uint32_t),
                    Hash(mesh->vertices.data(), mesh->vertices.size() * sizeof(Vector3), 0));
  TakeTriangles(*mesh);
  if (mesh->triangles.empty()) return Refuse(Reason::kInvalidValue, "indices", "no triangle of the mesh has an area");
  FindNeighbors(*mesh);
  TreeMaker maker(*mesh);
  FindAcross(*mesh);
  return TriangleMesh{std::move(mesh)};
}

Result<Heightfield> MakeHeightfield(uint32_t rows, uint32_t columns, double cell_size, std::vector<double> heights) {
  GENPHYS_RETURN_IF_ERROR(CheckHeights(rows, columns, cell_size, heights));
  WorkWatch::Spend(kPointWork * static_cast<int64_t>(heights.size()));
  auto field = std::make_shared<HeightfieldData>();
  field->rows = rows;
  field->columns = columns;
  field->cell_size = cell_size;
  field->heights = std::move(heights);
  field->hash =
      Hash(&cell_size, sizeof cell_size,
           Hash(field->heights.data(), field->heights.size() * sizeof(double), uint64_t{rows} << 32 | columns));
  MakeLevels(*field);
  return Heightfield{std::move(field)};
}

}  // namespace genphys

#include "genphys/surface.h"

#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <numeric>
#include <span>
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
// For one of a mesh, each time that something random in memory is looked for, and each time that the tree is halved.
constexpr int64_t kSearchWork = 20;
constexpr int64_t kTreeWork = 5;

// Height of a triangle over its longest side, in parts of that, below which it has no area.
constexpr double kFlatTriangle = 1e-10;
constexpr uint32_t kLeafTriangles = 4;

using Triangle = MeshData::Triangle;

uint64_t Hash(const void* data, size_t size, uint64_t seed) { return XXH3_64bits_withSeed(data, size, seed); }

// For each vertex the first one at the same place, found by a table without chains.
std::vector<uint32_t> Welded(const std::vector<Vector3>& vertices) {
  std::vector<uint32_t> places(std::bit_ceil(2 * vertices.size()), MeshData::kNone);
  std::vector<uint32_t> first(vertices.size());
  for (uint32_t i = 0; i < vertices.size(); ++i) {
    WorkWatch::Spend(kSearchWork);
    // Zeros of either sign are one place.
    const Vector3 vertex = vertices[i] + Vector3::Zero();
    size_t place = Hash(vertex.data(), sizeof vertex, 0) & (places.size() - 1);
    while (places[place] != MeshData::kNone && vertices[places[place]] != vertex) {
      place = (place + 1) & (places.size() - 1);
    }
    if (places[place] == MeshData::kNone) places[place] = i;
    first[i] = places[place];
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
    WorkWatch::Spend(kSearchWork);
    const Triangle t{welded[mesh.indices[i]], welded[mesh.indices[i + 1]], welded[mesh.indices[i + 2]]};
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0] || !HasArea(mesh, t)) continue;
    mesh.triangles.push_back(Turned(t));
  }
  std::sort(mesh.triangles.begin(), mesh.triangles.end());
  mesh.triangles.erase(std::unique(mesh.triangles.begin(), mesh.triangles.end()), mesh.triangles.end());
}

// Lists of something for each vertex, one after the other in memory.
template <typename Entry>
class ByVertex {
 public:
  // `visit(add)` calls add(vertex, entry) for all entries, twice the same.
  template <typename Visit>
  ByVertex(size_t vertices, const Visit& visit) : ends_(vertices + 1, 0) {
    visit([&](uint32_t vertex, const Entry&) { ++ends_[vertex + 1]; });
    std::partial_sum(ends_.begin(), ends_.end(), ends_.begin());
    entries_.resize(ends_.back());
    // From here on an end moves from the beginning of its list to where it belongs.
    visit([&](uint32_t vertex, const Entry& entry) { entries_[ends_[vertex]++] = entry; });
    for (uint32_t vertex = 0; vertex < vertices; ++vertex) {
      WorkWatch::Spend(kSearchWork * static_cast<int64_t>(1 + Of(vertex).size()));
      std::ranges::sort(Of(vertex));
    }
  }

  std::span<Entry> Of(uint32_t vertex) {
    const size_t begin = vertex == 0 ? 0 : ends_[vertex - 1];
    return std::span(entries_).subspan(begin, ends_[vertex] - begin);
  }

 private:
  std::vector<size_t> ends_;
  std::vector<Entry> entries_;
};

// An edge as it is walked round a triangle, at the vertex from which it goes.
struct Edge {
  uint32_t to;
  uint32_t third;  // corner
  uint32_t triangle;
  uint32_t k;  // of its beginning
  auto operator<=>(const Edge&) const = default;
};

// Which vertices are at a rim, and what lies beyond the edges of the triangles, in their order.
void FindAcross(MeshData& mesh) {
  ByVertex<Edge> edges(mesh.vertices.size(), [&](const auto& add) {
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      WorkWatch::Spend(kSearchWork);
      const Triangle& t = mesh.triangles[i];
      for (uint32_t k = 0; k < 3; ++k) add(t[k], Edge{t[(k + 1) % 3], t[(k + 2) % 3], i, k});
    }
  });
  mesh.is_at_rim.assign(mesh.vertices.size(), 0);
  mesh.across.assign(mesh.triangles.size(), {MeshData::kNone, MeshData::kNone, MeshData::kNone});
  for (uint32_t from = 0; from < mesh.vertices.size(); ++from) {
    const std::span<Edge> own = edges.Of(from);
    for (size_t i = 0; i < own.size(); ++i) {
      WorkWatch::Spend(kSearchWork);
      const uint32_t to = own[i].to;
      const auto back = std::ranges::equal_range(edges.Of(to), from, {}, &Edge::to);
      // Each edge is walked once in either direction, or the surface does not go on behind it.
      if (back.size() != 1) {
        mesh.is_at_rim[from] = mesh.is_at_rim[to] = 1;
        continue;
      }
      const bool is_only = (i == 0 || own[i - 1].to != to) && (i + 1 == own.size() || own[i + 1].to != to);
      if (is_only) mesh.across[own[i].triangle][own[i].k] = back.front().third;
    }
  }
}

void FindNeighbors(MeshData& mesh) {
  ByVertex<uint32_t> neighbors(mesh.vertices.size(), [&](const auto& add) {
    for (const Triangle& t : mesh.triangles) {
      WorkWatch::Spend(kSearchWork);
      for (size_t k = 0; k < 3; ++k) {
        add(t[k], t[(k + 1) % 3]);
        add(t[(k + 1) % 3], t[k]);
      }
    }
  });
  mesh.neighbor_first.reserve(mesh.vertices.size() + 1);
  for (uint32_t vertex = 0; vertex < mesh.vertices.size(); ++vertex) {
    mesh.neighbor_first.push_back(static_cast<uint32_t>(mesh.neighbors.size()));
    const std::span<uint32_t> all = neighbors.Of(vertex);
    std::ranges::unique_copy(all, std::back_inserter(mesh.neighbors));
  }
  mesh.neighbor_first.push_back(static_cast<uint32_t>(mesh.neighbors.size()));
  mesh.neighbors.shrink_to_fit();
}

// A tree over `triangles`, halved at the median of their middles along the widest axis. They and what lies across their
// edges are put into its order.
class TreeMaker {
 public:
  explicit TreeMaker(MeshData& mesh) : mesh_(mesh) {
    items_.reserve(mesh.triangles.size());
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      const Bounds bounds = BoundsOf(mesh.triangles[i]);
      items_.push_back({bounds.min + bounds.max, i});
    }
    mesh.nodes.reserve(items_.size());
    Make(0, static_cast<uint32_t>(items_.size()));
    mesh.triangles = InOrder(mesh.triangles);
    mesh.across = InOrder(mesh.across);
  }

 private:
  // Side by side, for each level of the tree goes over all of them.
  struct Item {
    Vector3 middle;
    uint32_t triangle;
  };

  std::vector<Triangle> InOrder(const std::vector<Triangle>& all) const {
    std::vector<Triangle> sorted;
    sorted.reserve(all.size());
    for (const Item& item : items_) sorted.push_back(all[item.triangle]);
    return sorted;
  }

  Bounds BoundsOf(const Triangle& t) const {
    const Vector3 &a = mesh_.vertices[t[0]], &b = mesh_.vertices[t[1]], &c = mesh_.vertices[t[2]];
    return {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
  }

  Bounds Make(uint32_t begin, uint32_t end) {
    WorkWatch::Spend(kTreeWork * (end - begin));
    const size_t node = mesh_.nodes.size();
    mesh_.nodes.emplace_back();
    if (end - begin <= kLeafTriangles) {
      Bounds bounds = BoundsOf(mesh_.triangles[items_[begin].triangle]);
      for (uint32_t i = begin + 1; i < end; ++i) {
        bounds = bounds.Union(BoundsOf(mesh_.triangles[items_[i].triangle]));
      }
      mesh_.nodes[node] = {.bounds = bounds, .first = begin, .count = end - begin};
      return bounds;
    }
    Bounds middles{items_[begin].middle, items_[begin].middle};
    for (uint32_t i = begin + 1; i < end; ++i) middles = middles.Union({items_[i].middle, items_[i].middle});
    int axis = 0;
    (middles.max - middles.min).maxCoeff(&axis);
    const uint32_t half = begin + (end - begin) / 2;
    std::nth_element(items_.begin() + begin, items_.begin() + half, items_.begin() + end,
                     [&](const Item& a, const Item& b) {
                       return std::pair(a.middle[axis], a.triangle) < std::pair(b.middle[axis], b.triangle);
                     });
    const Bounds first = Make(begin, half);
    const auto second_node = static_cast<uint32_t>(mesh_.nodes.size());
    const Bounds bounds = first.Union(Make(half, end));
    mesh_.nodes[node] = {.bounds = bounds, .first = second_node, .count = 0};
    return bounds;
  }

  MeshData& mesh_;
  std::vector<Item> items_;
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
  FindAcross(*mesh);
  TreeMaker maker(*mesh);
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

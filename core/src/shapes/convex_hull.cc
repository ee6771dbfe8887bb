#include "genphys/convex_hull.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "genphys/bounds.h"
#include "genphys/limits.h"
#include "genphys/work_watch.h"
#include "model/cat.h"
#include "model/validate.h"
#include "shapes/hull_triangles.h"
#include "shapes/polyhedron.h"

namespace genphys {
namespace {

// Parts of the extent. Corners that came in single precision lie this far from the planes of their faces.
constexpr double kCoplanar = 5e-7;
// A corner nearer than this to the line between its neighbours is none.
constexpr double kCollinear = 1e-9;
constexpr double kThicknessMin = 1e-5;
// m: what the smallest box has, less something for rounding.
constexpr double kThinnest = 2 * Limits::kSizeMin * (1 - 1e-9);
// Faces times vertices that are looked at for the thickness; the rest of a finer hull is too small to matter.
constexpr size_t kThicknessWork = 4'000'000;

// Of a WorkWatch.
constexpr int64_t kPointWork = 1000;

// The hull in the making: centred, and scaled to an extent of about one.
struct Maker {
  std::vector<Vector3> points;
  std::vector<HullTriangle> triangles;
  std::vector<Vector3> normals;
  std::vector<uint32_t> region;  // of each triangle
  std::vector<std::array<uint32_t, 3>> neighbors;
};

Vector3 AreaVector(const Maker& maker, const HullTriangle& t) {
  return (maker.points[t[1]] - maker.points[t[0]]).cross(maker.points[t[2]] - maker.points[t[0]]);
}

// Points that are there twice are taken once, by the first of their numbers.
std::vector<HullTriangle> TrianglesAround(const std::vector<Vector3>& points) {
  std::vector<uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  const auto place = [&](uint32_t i) { return std::tuple(points[i].x(), points[i].y(), points[i].z()); };
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return place(a) < place(b); });
  const auto is_same = [&](uint32_t a, uint32_t b) { return place(a) == place(b); };
  order.erase(std::unique(order.begin(), order.end(), is_same), order.end());
  std::sort(order.begin(), order.end());
  std::vector<Vector3> distinct;
  for (const uint32_t number : order) distinct.push_back(points[number]);
  std::vector<HullTriangle> triangles = HullTriangles(distinct);
  for (HullTriangle& triangle : triangles) {
    for (uint32_t& number : triangle) number = order[number];
  }
  return triangles;
}

void FindNeighbors(Maker& maker) {
  const auto key = [](uint32_t from, uint32_t to) { return uint64_t{from} << 32 | to; };
  std::unordered_map<uint64_t, uint32_t> sides;
  sides.reserve(3 * maker.triangles.size());
  for (uint32_t i = 0; i < maker.triangles.size(); ++i) {
    const HullTriangle& t = maker.triangles[i];
    for (size_t k = 0; k < 3; ++k) sides[key(t[k], t[(k + 1) % 3])] = i;
  }
  maker.neighbors.resize(maker.triangles.size());
  for (uint32_t i = 0; i < maker.triangles.size(); ++i) {
    const HullTriangle& t = maker.triangles[i];
    for (size_t k = 0; k < 3; ++k) {
      const auto twin = sides.find(key(t[(k + 1) % 3], t[k]));
      maker.neighbors[i][k] = twin == sides.end() ? i : twin->second;
    }
  }
}

// The convex polygon around `points` as seen against `normal`, anticlockwise (Andrew's monotone chain).
std::vector<uint32_t> PolygonAround(const Maker& maker, std::vector<uint32_t> numbers, const Vector3& normal) {
  const Vector3 u = normal.unitOrthogonal(), v = normal.cross(u);
  struct Flat {
    double x, y;
    uint32_t number;
  };
  std::vector<Flat> flats;
  for (const uint32_t number : numbers)
    flats.push_back({u.dot(maker.points[number]), v.dot(maker.points[number]), number});
  std::sort(flats.begin(), flats.end(),
            [](const Flat& a, const Flat& b) { return std::tie(a.x, a.y) < std::tie(b.x, b.y); });
  std::vector<Flat> chain;
  const auto turns_left = [&](const Flat& a, const Flat& b, const Flat& c) {
    const double length = std::hypot(c.x - a.x, c.y - a.y);
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) > kCollinear * length;
  };
  const auto extend = [&](const Flat& flat, size_t keep) {
    while (chain.size() > keep + 1 && !turns_left(chain[chain.size() - 2], chain.back(), flat)) chain.pop_back();
    chain.push_back(flat);
  };
  for (const Flat& flat : flats) extend(flat, 0);
  const size_t upper = chain.size() - 1;
  for (size_t i = flats.size(); i-- > 0;) extend(flats[i], upper);
  chain.pop_back();
  std::vector<uint32_t> polygon;
  for (const Flat& flat : chain) polygon.push_back(flat.number);
  return polygon;
}

// Grows a face from `seed` over all triangles that lie in its plane; gives the points of them.
std::vector<uint32_t> Flood(Maker& maker, uint32_t seed, uint32_t region) {
  const Vector3 normal = maker.normals[seed];
  const double offset = normal.dot(maker.points[maker.triangles[seed][0]]);
  const auto is_flat = [&](uint32_t triangle) {
    const HullTriangle& t = maker.triangles[triangle];
    return std::all_of(t.begin(), t.end(),
                       [&](uint32_t p) { return std::abs(normal.dot(maker.points[p]) - offset) <= kCoplanar; });
  };
  std::vector<uint32_t> open{seed}, points;
  maker.region[seed] = region;
  while (!open.empty()) {
    const uint32_t triangle = open.back();
    open.pop_back();
    points.insert(points.end(), maker.triangles[triangle].begin(), maker.triangles[triangle].end());
    for (const uint32_t neighbor : maker.neighbors[triangle]) {
      if (maker.region[neighbor] != 0 || !is_flat(neighbor)) continue;
      maker.region[neighbor] = region;
      open.push_back(neighbor);
    }
  }
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

struct MakerFace {
  Vector3 normal = Vector3::Zero();
  std::vector<uint32_t> corners;  // numbers of points
};

// The largest first.
std::vector<MakerFace> FacesOf(Maker& maker) {
  FindNeighbors(maker);
  std::vector<double> areas;
  for (const HullTriangle& t : maker.triangles) {
    const Vector3 area = AreaVector(maker, t);
    areas.push_back(area.norm());
    maker.normals.push_back(area.normalized());
  }
  std::vector<uint32_t> order(maker.triangles.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return areas[a] > areas[b]; });
  maker.region.assign(maker.triangles.size(), 0);
  std::vector<MakerFace> faces;
  for (const uint32_t seed : order) {
    if (maker.region[seed] != 0 || !(areas[seed] > 0)) continue;
    WorkWatch::Spend(kPointWork);
    const std::vector<uint32_t> points = Flood(maker, seed, static_cast<uint32_t>(faces.size()) + 1);
    std::vector<uint32_t> corners = PolygonAround(maker, points, maker.normals[seed]);
    if (corners.size() >= 3) faces.push_back({maker.normals[seed], std::move(corners)});
  }
  return faces;
}

// Lists of lists in two columns.
void Pack(const std::vector<std::vector<uint32_t>>& lists, std::vector<uint32_t>& first, std::vector<uint32_t>& items) {
  first.assign(1, 0);
  for (const std::vector<uint32_t>& list : lists) {
    items.insert(items.end(), list.begin(), list.end());
    first.push_back(static_cast<uint32_t>(items.size()));
  }
}

void TakeFaces(const std::vector<MakerFace>& faces, HullData& hull) {
  std::vector<uint32_t> number(hull.points.size(), 0);
  for (const MakerFace& face : faces) {
    for (const uint32_t corner : face.corners) number[corner] = 1;
  }
  for (size_t i = 0; i < number.size(); ++i) {
    if (number[i] == 0) continue;
    number[i] = static_cast<uint32_t>(hull.vertices.size());
    hull.vertices.push_back(hull.points[i]);
  }
  std::vector<std::vector<uint32_t>> neighbors(hull.vertices.size()), at(hull.vertices.size());
  for (const MakerFace& made : faces) {
    HullData::Face face{.normal = made.normal,
                        .offset = made.normal.dot(hull.points[made.corners[0]]),
                        .first = static_cast<uint32_t>(hull.face_corners.size()),
                        .count = static_cast<uint32_t>(made.corners.size())};
    for (size_t i = 0; i < made.corners.size(); ++i) {
      const uint32_t from = number[made.corners[i]], to = number[made.corners[(i + 1) % made.corners.size()]];
      face.offset = std::max(face.offset, face.normal.dot(hull.vertices[from]));
      hull.face_corners.push_back(from);
      at[from].push_back(static_cast<uint32_t>(hull.faces.size()));
      neighbors[from].push_back(to);
      neighbors[to].push_back(from);
    }
    hull.faces.push_back(face);
  }
  for (std::vector<uint32_t>& list : neighbors) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  Pack(neighbors, hull.neighbor_first, hull.neighbors);
  Pack(at, hull.vertex_face_first, hull.vertex_faces);
}

// The mass is that of the surface of triangles, which is closed, while merged faces only nearly meet.
void Measure(const std::vector<HullTriangle>& triangles, HullData& hull) {
  hull.low = hull.high = hull.vertices[0];
  for (const Vector3& vertex : hull.vertices) {
    hull.low = hull.low.cwiseMin(vertex);
    hull.high = hull.high.cwiseMax(vertex);
  }
  Polyhedron polyhedron((hull.low + hull.high) / 2);
  hull.thickness = (hull.high - hull.low).minCoeff();
  size_t looked_at = 0;
  for (const HullTriangle& t : triangles) polyhedron.Add(hull.points[t[0]], hull.points[t[1]], hull.points[t[2]]);
  for (const HullData::Face& face : hull.faces) {
    looked_at += hull.vertices.size();
    if (looked_at > kThicknessWork) continue;
    WorkWatch::Spend(static_cast<int64_t>(hull.vertices.size()));
    double lowest = face.offset;
    for (const Vector3& vertex : hull.vertices) lowest = std::min(lowest, face.normal.dot(vertex));
    hull.thickness = std::min(hull.thickness, face.offset - lowest);
  }
  hull.volume = polyhedron.volume();
  hull.center_of_mass = polyhedron.center();
  hull.tensor = polyhedron.tensor();
}

Status CheckPoints(const std::vector<Vector3>& points) {
  if (points.size() < 4) return Refuse(Reason::kInvalidValue, "vertices", "a body needs four points or more");
  for (size_t i = 0; i < points.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const double number = points[i][k];
      if (std::abs(number) <= Limits::kSizeMax) continue;
      return CheckNumber(number, -Limits::kSizeMax, Limits::kSizeMax,
                         Cat("vertices[", 3 * i + static_cast<size_t>(k), "]"));
    }
  }
  return absl::OkStatus();
}

// How far the points reach out of the widest triangle that three of them span, which is nothing for a flat set.
double HeightOf(const std::vector<Vector3>& points) {
  const auto farthest = [&](const auto& distance) {
    return *std::max_element(points.begin(), points.end(),
                             [&](const Vector3& a, const Vector3& b) { return distance(a) < distance(b); });
  };
  const Vector3 a = farthest([&](const Vector3& p) { return (p - points[0]).squaredNorm(); });
  const Vector3 b = farthest([&](const Vector3& p) { return (p - a).squaredNorm(); });
  const Vector3 along = (b - a).normalized();
  const Vector3 c = farthest([&](const Vector3& p) { return (p - a).cross(along).squaredNorm(); });
  const Vector3 normal = along.cross(c - a).normalized();
  double low = 0, high = 0;
  for (const Vector3& p : points) {
    low = std::min(low, normal.dot(p - a));
    high = std::max(high, normal.dot(p - a));
  }
  return std::min(high - low, (c - a).cross(along).norm());
}

}  // namespace

bool ConvexHull::operator==(const ConvexHull& o) const {
  if (data == o.data || data == nullptr || o.data == nullptr) return data == o.data;
  return data->hash == o.data->hash && data->points == o.data->points;
}

Result<ConvexHull> MakeConvexHull(std::vector<Vector3> points) {
  GENPHYS_RETURN_IF_ERROR(CheckPoints(points));
  WorkWatch::Spend(kPointWork * static_cast<int64_t>(points.size()));
  Bounds bounds{points[0], points[0]};
  for (const Vector3& p : points) bounds = bounds.Union({p, p});
  const Vector3 middle = (bounds.min + bounds.max) / 2;
  const double extent = (bounds.max - bounds.min).maxCoeff();
  const double height = HeightOf(points);
  // True for NaN as well.
  if (!(height >= kThicknessMin * extent)) {
    return Refuse(Reason::kInvalidValue, "vertices", "the points lie in a plane, or too near to one to bound a body");
  }
  Maker maker;
  maker.points.reserve(points.size());
  for (const Vector3& p : points) maker.points.push_back((p - middle) / extent);
  maker.triangles = TrianglesAround(maker.points);
  std::vector<MakerFace> faces = FacesOf(maker);
  if (faces.size() < 4) return Refuse(Reason::kInvalidValue, "vertices", "the points bound no body");

  auto hull = std::make_shared<HullData>();
  hull->points = std::move(points);
  hull->hash = XXH3_64bits(hull->points.data(), hull->points.size() * sizeof(Vector3));
  TakeFaces(faces, *hull);
  Measure(maker.triangles, *hull);
  if (!(hull->volume > 0) || !(hull->thickness >= kThinnest)) {
    return Refuse(Reason::kInvalidValue, "vertices", "the hull of the points is too thin to be a body");
  }
  return ConvexHull{std::move(hull)};
}

}  // namespace genphys

#include "shapes/clipping.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "genphys/work_watch.h"

namespace genphys {
namespace {

// Within this of one is the cosine between a normal and a face that the contact is taken to be flat on it.
constexpr double kFlat = 1e-6;
// Of two faces that are as good as parallel the same one is taken every time.
constexpr double kSameFlat = 1e-11;
// Sine between two edges, or between an edge and the surface that it meets, below which it lies along.
constexpr double kAlong = 1e-3;
// Of the size of a face: by so much it is taken to be wider, lest a point on the seam of two be on neither.
constexpr double kSeam = 1e-9;
// Of the radius of a ball: by so much a face is wider to that. Over the bend of two that are as good as level its
// lowest point as seen along the normal of either lies beyond the edge.
constexpr double kBend = 2e-6;
// A later point replaces an earlier one only if it is better by more than rounding, so that the choice among equals
// stays the same from step to step.
constexpr double kBetter = 1 + 1e-6;
// Of the largest distance between points: those whose depths differ by no more are equals. Eight corners of two turned
// faces carry a stack in turns that the least lean decides, and a solve does not start from what held it: of 8 towers
// of 10 cubes of 10 cm, each turned, all fell on Bullet with 1e-7; from 1e-4 to 0.2 all stand alike.
constexpr double kDeeper = 1e-3;
// Of the same: so much farther along a direction lies what is another point than an equal one.
constexpr double kFarther = 1e-6;
// rad, by which the directions along which points are looked for lie beside the corners of a face: no corner of a
// square or a polygon of 8, 16 or 32 corners lies as far along one as its neighbour does.
constexpr double kAside = 0.07;

// Of a WorkWatch, for each corner that may be cut off.
constexpr int64_t kCutWork = 8;

using Polygon = absl::InlinedVector<CutCorner, 8>;

// Edges beyond the last that there is a bit for share it.
uint32_t BitOf(size_t edge) { return uint32_t{1} << std::min<size_t>(edge, 31); }

// What of `polygon`, or of a segment or point, has dot(normal, p) <= offset, which is within this `edge`.
Polygon Cut(const Polygon& polygon, const Vector3& normal, double offset, size_t edge) {
  Polygon kept;
  const size_t count = polygon.size();
  // The one edge of a segment is not to be walked twice.
  const size_t edges = count == 2 ? 1 : count;
  for (size_t i = 0; i < edges; ++i) {
    const CutCorner& from = polygon[i];
    const CutCorner& to = polygon[(i + 1) % count];
    const double above_from = normal.dot(from.position) - offset, above_to = normal.dot(to.position) - offset;
    if (above_from <= 0) kept.push_back(from);
    if ((above_from < 0 && above_to > 0) || (above_from > 0 && above_to < 0)) {
      const Vector3 along = to.position - from.position;
      kept.push_back({.position = from.position + above_from / (above_from - above_to) * along,
                      .outward = above_from < 0 ? along : Vector3(-along),
                      .edges = (from.edges & to.edges) | BitOf(edge)});
    }
    if (count == 2 && above_to <= 0) kept.push_back(to);
  }
  return kept;
}

double Area(const Vector3& a, const Vector3& b, const Vector3& c) { return (b - a).cross(c - a).norm(); }

bool IsNoSeam(const CutCorner&, const SolidFeature&, double) { return false; }

// A solid on one side of a contact, seen along the direction in which it faces the other.
struct Side {
  const Solid& solid;
  SolidFeature feature;
};

// The points in which `incident` lies before or behind the polygon `reference`, within its edges as seen along `view`;
// those that are only where the two were cut go to `seams` where `is_seam` says so. `sign` turns the normal of the
// polygon into that of the contact.
void ClipToPolygon(const Side& reference, const Side& incident, const Vector3& view, double sign, SeamTest is_seam,
                   PointSet& points, PointSet& seams) {
  const SolidFeature& face = reference.feature;
  Polygon polygon;
  for (const Vector3& corner : incident.feature.corners) polygon.push_back({.position = corner});
  Vector3 middle = Vector3::Zero();
  for (const Vector3& corner : face.corners) middle += corner / static_cast<double>(face.corners.size());
  const double wider = polygon.size() == 1 ? kBend * incident.solid.radius() : 0;
  for (size_t i = 0; i < face.corners.size() && !polygon.empty(); ++i) {
    WorkWatch::Look(kCutWork * static_cast<int64_t>(polygon.size()));
    const Vector3& from = face.corners[i];
    const Vector3& to = face.corners[(i + 1) % face.corners.size()];
    Vector3 outward = (to - from).cross(view).normalized();
    if (outward.dot(from - middle) < 0) outward = -outward;
    const double inside = outward.dot(from - middle);
    polygon = Cut(polygon, outward, outward.dot(from) + kSeam * inside + wider, i);
  }
  double level = face.normal.dot(face.corners[0]);
  for (const Vector3& corner : face.corners) level = std::max(level, face.normal.dot(corner));
  level += reference.solid.radius();
  for (const CutCorner& corner : polygon) {
    const double gap = face.normal.dot(corner.position) - incident.solid.radius() - level;
    PointSet& taking = corner.edges != 0 && is_seam(corner, incident.feature, -gap) ? seams : points;
    taking.Add({.position = corner.position - (incident.solid.radius() + gap / 2) * face.normal,
                .normal = sign * face.normal,
                .depth = -gap});
  }
}

// The edge of a feature that lies across `normal`, if it has one there.
std::optional<std::pair<Vector3, Vector3>> EdgeAcross(const SolidFeature& feature, const Vector3& outward) {
  const size_t count = feature.corners.size();
  if (count < 2) return std::nullopt;
  size_t best = 0;
  double highest = -std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < (count == 2 ? 1 : count); ++i) {
    const double lower = std::min(outward.dot(feature.corners[i]), outward.dot(feature.corners[(i + 1) % count]));
    if (lower > highest) highest = lower, best = i;
  }
  const Vector3 &from = feature.corners[best], &to = feature.corners[(best + 1) % count];
  if (std::abs(outward.dot(to - from)) > kAlong * (to - from).norm()) return std::nullopt;
  return std::pair(from, to);
}

// The ends of the stretch over which two edges, nearly parallel and both across `normal`, run side by side.
void OverlapEdges(const Side& a, const Side& b, const Vector3& normal, PointSet& points) {
  const auto edge_a = EdgeAcross(a.feature, normal), edge_b = EdgeAcross(b.feature, -normal);
  if (!edge_a || !edge_b) return;
  const Vector3 along_a = edge_a->second - edge_a->first, along_b = edge_b->second - edge_b->first;
  const double length = along_a.norm();
  if (along_a.cross(along_b).norm() > kAlong * length * along_b.norm()) return;
  const Vector3 axis = along_a / length;
  const double first = axis.dot(edge_b->first - edge_a->first), second = axis.dot(edge_b->second - edge_a->first);
  const double low = std::max(0.0, std::min(first, second)), high = std::min(length, std::max(first, second));
  if (low >= high || first == second) return;
  for (const double at : {low, high}) {
    const Vector3 on_a = edge_a->first + at * axis + a.solid.radius() * normal;
    const Vector3 on_b = edge_b->first + (at - first) / (second - first) * along_b - b.solid.radius() * normal;
    points.Add({.position = (on_a + on_b) / 2, .normal = normal, .depth = normal.dot(on_a - on_b)});
  }
}

// Some of many points, by their places in ascending order.
struct FewPoints {
  std::array<int, Manifold::kPointsPerNormal> places{};
  int count = 0;
};

// Each of `chosen` once.
FewPoints InOrder(std::array<size_t, Manifold::kPointsPerNormal> chosen) {
  FewPoints few;
  std::sort(chosen.begin(), chosen.end());
  const auto end = std::unique(chosen.begin(), chosen.end());
  for (auto it = chosen.begin(); it != end; ++it) few.places[static_cast<size_t>(few.count++)] = static_cast<int>(*it);
  return few;
}

// The deepest of the points in which two surfaces meet along one normal, and those that span the widest area with it.
// Equals are told apart by more than rounding, so that the choice stays the same from step to step.
FewPoints ChooseFew(std::span<const MeetingPoint> points) {
  FewPoints few;
  if (points.size() <= few.places.size()) {
    few.count = static_cast<int>(points.size());
    for (int i = 0; i < few.count; ++i) few.places[static_cast<size_t>(i)] = i;
    return few;
  }
  const auto position = [&](size_t i) -> const Vector3& { return points[i].position; };
  double widest = 0, deepest = -std::numeric_limits<double>::infinity();
  Vector3 middle = Vector3::Zero();
  for (const MeetingPoint& point : points) {
    widest = std::max(widest, (point.position - position(0)).norm());
    deepest = std::max(deepest, point.depth);
    middle += point.position / static_cast<double>(points.size());
  }
  std::array<size_t, Manifold::kPointsPerNormal> chosen{};
  // Of those as deep as the deepest the one that lies farthest out.
  double farthest = -1;
  for (size_t i = 0; i < points.size(); ++i) {
    const double distance = (position(i) - middle).squaredNorm();
    if (points[i].depth < deepest - kDeeper * widest || distance <= farthest * kBetter) continue;
    farthest = distance;
    chosen[0] = i;
  }
  // Farthest from the first, then the widest triangle, then the point that adds most to it.
  double best = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double distance = (position(i) - position(chosen[0])).squaredNorm();
    if (distance > best * kBetter) best = distance, chosen[1] = i;
  }
  best = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double area = Area(position(chosen[0]), position(chosen[1]), position(i));
    if (area > best * kBetter) best = area, chosen[2] = i;
  }
  const double triangle = Area(position(chosen[0]), position(chosen[1]), position(chosen[2]));
  best = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    // Inside the triangle the three parts only add up to it.
    const double gain = Area(position(chosen[0]), position(chosen[1]), position(i)) +
                        Area(position(chosen[1]), position(chosen[2]), position(i)) +
                        Area(position(chosen[2]), position(chosen[0]), position(i)) - triangle;
    if (gain > best * kBetter + triangle * (kBetter - 1)) best = gain, chosen[3] = i;
  }
  return InOrder(chosen);
}

// Those that lie farthest along four directions across each other, the first of them `axis`, and the deepest. What is
// round has many points alike, all of which span the same area: chosen by that alone they would be others after the
// least sway, of which no solve knows what held them.
FewPoints ChooseAlong(std::span<const MeetingPoint> points, const Vector3& axis) {
  const Vector3& normal = points.front().normal;
  const Vector3 level = (axis - normal * normal.dot(axis)).normalized();
  const Vector3 first = std::cos(kAside) * level + std::sin(kAside) * normal.cross(level), second = normal.cross(first);
  const std::array<Vector3, Manifold::kPointsPerNormal> directions{first, second, -first, -second};
  double widest = 0;
  size_t deepest = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    widest = std::max(widest, (points[i].position - points[0].position).norm());
    if (points[i].depth > points[deepest].depth) deepest = i;
  }
  std::array<size_t, Manifold::kPointsPerNormal> chosen{};
  for (size_t k = 0; k < chosen.size(); ++k) {
    double farthest = -std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < points.size(); ++i) {
      const double along = directions[k].dot(points[i].position - points[0].position);
      if (along > farthest + kFarther * widest) farthest = along, chosen[k] = i;
    }
  }
  const auto is_shallower = [&](size_t i) { return points[i].depth < points[deepest].depth - kDeeper * widest; };
  if (std::ranges::all_of(chosen, is_shallower)) {
    *std::ranges::min_element(
        chosen, {}, [&](size_t i) { return (points[i].position - points[deepest].position).squaredNorm(); }) = deepest;
  }
  return InOrder(chosen);
}

}  // namespace

void PointSet::Add(const MeetingPoint& point) {
  if (!(point.depth >= -gap_)) return;
  points_.push_back(point);
  deepest_ = std::max(deepest_, point.depth);
}

void PointSet::ReduceTo(Manifold& manifold) const {
  const bool are_many = points_.size() > Manifold::kPointsPerNormal;
  const FewPoints few = are_many && !axis_.isZero(0) ? ChooseAlong(points_, axis_) : ChooseFew(points_);
  for (int i = 0; i < few.count; ++i) manifold.Add(points_[static_cast<size_t>(few.places[static_cast<size_t>(i)])]);
}

void AddFlatPoints(const Solid& a, const Solid& b, const Vector3& normal, PointSet& points) {
  AddFlatPoints(a, b, normal, IsNoSeam, points, points);
}

void AddFlatPoints(const Solid& a, const Solid& b, const Vector3& normal, SeamTest is_seam, PointSet& points,
                   PointSet& seams) {
  const Side side_a{a, a.FeatureAt(normal)}, side_b{b, b.FeatureAt(-normal)};
  const double flat_a = side_a.feature.is_polygon() ? side_a.feature.normal.dot(normal) : -1;
  const double flat_b = side_b.feature.is_polygon() ? -side_b.feature.normal.dot(normal) : -1;
  const SolidFeature& polygon = side_a.feature.is_polygon() ? side_a.feature : side_b.feature;
  if (polygon.is_polygon()) points.SetAxis(polygon.corners[0] - polygon.corners[polygon.corners.size() / 2]);
  if (flat_a >= 1 - kFlat && flat_a >= flat_b - kSameFlat) {
    ClipToPolygon(side_a, {b, b.FeatureAt(-side_a.feature.normal)}, side_a.feature.normal, 1, is_seam, points, seams);
  } else if (flat_b >= 1 - kFlat) {
    ClipToPolygon(side_b, {a, a.FeatureAt(-side_b.feature.normal)}, side_b.feature.normal, -1, IsNoSeam, points, seams);
  } else {
    OverlapEdges(side_a, side_b, normal, points);
  }
}

void AddUprightPoints(const Solid& a, const Solid& b, const Vector3& normal, SeamTest is_seam, PointSet& points,
                      PointSet& seams) {
  ClipToPolygon({a, a.FeatureAt(normal)}, {b, b.FeatureAt(-normal)}, Vector3::UnitZ(), 1, is_seam, points, seams);
}

}  // namespace genphys

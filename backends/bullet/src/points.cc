#include "points.h"

#include <algorithm>
#include <utility>

namespace genphys::bullet_backend {
namespace {

// A later candidate replaces an earlier one only if it is better by more than rounding, so that the choice among
// equals stays the same from step to step.
constexpr double kBetter = 1 + 1e-6;
// m, for the same purpose, of depths.
constexpr double kDeeper = 1e-9;

// A convex polygon, or a segment if it has two corners.
struct Polygon {
  std::array<Vector3, PointSet::kMax> corners;
  int count = 0;

  void Add(const Vector3& corner) {
    if (count < PointSet::kMax) corners[static_cast<size_t>(count++)] = corner;
  }
  const Vector3& operator[](int i) const { return corners[static_cast<size_t>(i)]; }
};

// What of `polygon` has dot(normal, p) <= offset.
Polygon Cut(const Polygon& polygon, const Vector3& normal, double offset) {
  Polygon kept;
  // The one edge of a segment is not to be walked twice.
  const int edges = polygon.count == 2 ? 1 : polygon.count;
  for (int i = 0; i < edges; ++i) {
    const Vector3& from = polygon[i];
    const Vector3& to = polygon[(i + 1) % polygon.count];
    const double above_from = normal.dot(from) - offset, above_to = normal.dot(to) - offset;
    if (above_from <= 0) kept.Add(from);
    if ((above_from < 0 && above_to > 0) || (above_from > 0 && above_to < 0)) {
      kept.Add(from + above_from / (above_from - above_to) * (to - from));
    }
    if (edges == 1 && above_to <= 0) kept.Add(to);
  }
  return kept;
}

double Area(const Vector3& a, const Vector3& b, const Vector3& c) { return (b - a).cross(c - a).norm(); }

}  // namespace

void PointSet::Add(const MeetingPoint& point) {
  if (point.depth < -kContactGap || count_ == kMax) return;
  points_[static_cast<size_t>(count_++)] = point;
}

void PointSet::ReduceTo(Manifold& meeting) const {
  if (count_ <= Manifold::kPointsPerNormal) {
    std::copy_n(points_.begin(), count_, meeting.points.begin());
    meeting.count = count_;
    return;
  }
  const auto position = [&](size_t i) -> const Vector3& { return points_[i].position; };
  const auto count = static_cast<size_t>(count_);
  std::array<size_t, Manifold::kPointsPerNormal> chosen{};
  for (size_t i = 1; i < count; ++i) {
    if (points_[i].depth > points_[chosen[0]].depth + kDeeper) chosen[0] = i;
  }
  // Farthest from the first, then the widest triangle, then the point that adds most to it.
  double best = 0;
  for (size_t i = 0; i < count; ++i) {
    const double distance = (position(i) - position(chosen[0])).squaredNorm();
    if (distance > best * kBetter) best = distance, chosen[1] = i;
  }
  best = 0;
  for (size_t i = 0; i < count; ++i) {
    const double area = Area(position(chosen[0]), position(chosen[1]), position(i));
    if (area > best * kBetter) best = area, chosen[2] = i;
  }
  best = 0;
  const double triangle = Area(position(chosen[0]), position(chosen[1]), position(chosen[2]));
  for (size_t i = 0; i < count; ++i) {
    const double around = Area(position(chosen[0]), position(chosen[1]), position(i)) +
                          Area(position(chosen[1]), position(chosen[2]), position(i)) +
                          Area(position(chosen[2]), position(chosen[0]), position(i));
    // Inside the triangle the three parts only add up to it.
    const double gain = around - triangle;
    if (gain > best * kBetter + triangle * (kBetter - 1)) best = gain, chosen[3] = i;
  }
  std::sort(chosen.begin(), chosen.end());
  const auto end = std::unique(chosen.begin(), chosen.end());
  meeting.count = 0;
  for (auto it = chosen.begin(); it != end; ++it) meeting.points[static_cast<size_t>(meeting.count++)] = points_[*it];
}

void ClipToPolygon(const SurfaceFeature& reference, const SurfaceFeature& incident, bool reference_is_b,
                   PointSet& points) {
  Polygon polygon;
  for (int i = 0; i < incident.count; ++i) polygon.Add(incident.vertices[static_cast<size_t>(i)]);
  Vector3 middle = Vector3::Zero();
  for (int i = 0; i < reference.count; ++i) middle += reference.vertices[static_cast<size_t>(i)] / reference.count;
  for (int i = 0; i < reference.count && polygon.count > 0; ++i) {
    const Vector3& from = reference.vertices[static_cast<size_t>(i)];
    const Vector3& to = reference.vertices[static_cast<size_t>((i + 1) % reference.count)];
    Vector3 outward = (to - from).cross(reference.normal);
    if (outward.dot(from - middle) < 0) outward = -outward;
    polygon = Cut(polygon, outward, outward.dot(from));
  }
  const double level = reference.normal.dot(reference.vertices[0]);
  for (int i = 0; i < polygon.count; ++i) {
    const double gap = reference.normal.dot(polygon[i]) - level;
    points.Add({.position = polygon[i] - gap / 2 * reference.normal,
                .normal = reference_is_b ? Vector3(-reference.normal) : reference.normal,
                .depth = -gap});
  }
}

}  // namespace genphys::bullet_backend

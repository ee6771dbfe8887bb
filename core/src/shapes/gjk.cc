#include "shapes/gjk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace genphys {
namespace {

constexpr int kIterationsMax = 100;
// Of the squared distance: by how much the lower bound may lie below it.
constexpr double kConverged = 1e-13;
// Of the longest edge's cube: a tetrahedron with less volume has no inside.
constexpr double kFlat = 1e-13;

// A point of the difference of the two cores.
struct Corner {
  Vector3 point;  // on a less on b
  Vector3 on_a;
  Vector3 on_b;
};

// Up to four corners, and the weights by which they make up the point of their hull that is closest to the origin.
struct Simplex {
  std::array<Corner, 4> corners;
  std::array<double, 4> weights{};
  size_t count = 0;

  Vector3 Closest() const {
    Vector3 sum = Vector3::Zero();
    for (size_t i = 0; i < count; ++i) sum += weights[i] * corners[i].point;
    return sum;
  }
};

Simplex Pick(const Simplex& from, std::initializer_list<std::pair<size_t, double>> chosen) {
  Simplex simplex;
  for (const auto& [corner, weight] : chosen) {
    simplex.corners[simplex.count] = from.corners[corner];
    simplex.weights[simplex.count++] = weight;
  }
  return simplex;
}

Simplex ClosestOnSegment(const Simplex& s, size_t a, size_t b) {
  const Vector3& from = s.corners[a].point;
  const Vector3 edge = s.corners[b].point - from;
  const double along = -from.dot(edge), square = edge.squaredNorm();
  if (!(along > 0)) return Pick(s, {{a, 1}});
  if (along >= square) return Pick(s, {{b, 1}});
  return Pick(s, {{a, 1 - along / square}, {b, along / square}});
}

Simplex Nearer(const Simplex& x, const Simplex& y) {
  return y.Closest().squaredNorm() < x.Closest().squaredNorm() ? y : x;
}

// By barycentric coordinates where the foot of the origin lies inside, else on the nearest edge.
Simplex ClosestOnTriangle(const Simplex& s, size_t a, size_t b, size_t c) {
  // From differences, which stay exact while the triangle shrinks far away from the origin.
  const Vector3& p = s.corners[a].point;
  const Vector3 q = s.corners[b].point - p, r = s.corners[c].point - p;
  const Vector3 normal = q.cross(r);
  const double square = normal.squaredNorm();
  const double at_q = r.cross(p).dot(normal), at_r = p.cross(q).dot(normal);
  if (at_q > 0 && at_r > 0 && at_q + at_r < square) {
    return Pick(s, {{a, 1 - (at_q + at_r) / square}, {b, at_q / square}, {c, at_r / square}});
  }
  return Nearer(Nearer(ClosestOnSegment(s, a, b), ClosestOnSegment(s, b, c)), ClosestOnSegment(s, c, a));
}

// Four corners left: the origin is inside.
Simplex ClosestOnTetrahedron(const Simplex& s) {
  static constexpr std::array<std::array<size_t, 4>, 4> kFaces{
      {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}}};
  const auto point = [&](size_t i) -> const Vector3& { return s.corners[i].point; };
  const double volume = (point(1) - point(0)).dot((point(2) - point(0)).cross(point(3) - point(0)));
  double longest = 0;
  for (size_t i = 0; i < 4; ++i) longest = std::max(longest, (point(i) - point((i + 1) % 4)).squaredNorm());
  const bool is_flat = std::abs(volume) <= kFlat * longest * std::sqrt(longest);
  Simplex best;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c, opposite] : kFaces) {
    const Vector3 normal = (point(b) - point(a)).cross(point(c) - point(a));
    const double origin_side = -normal.dot(point(a)), inner_side = normal.dot(point(opposite) - point(a));
    if (!is_flat && origin_side * inner_side >= 0) continue;
    const Simplex on_face = ClosestOnTriangle(s, a, b, c);
    const double distance = on_face.Closest().squaredNorm();
    if (distance >= least) continue;
    least = distance;
    best = on_face;
  }
  return best.count > 0 ? best : s;
}

Simplex Reduced(const Simplex& s) {
  switch (s.count) {
    case 1:
      return Pick(s, {{0, 1}});
    case 2:
      return ClosestOnSegment(s, 0, 1);
    case 3:
      return ClosestOnTriangle(s, 0, 1, 2);
    default:
      return ClosestOnTetrahedron(s);
  }
}

// The closest point of `s` once more, exactly across its edges: a weight that is off in its last digits is off by more
// of a long edge than a near origin is away.
Vector3 Across(const Simplex& s) {
  const Vector3 closest = s.Closest();
  if (s.count == 2) {
    const Vector3 edge = s.corners[1].point - s.corners[0].point;
    return closest - closest.dot(edge) / edge.squaredNorm() * edge;
  }
  if (s.count != 3) return closest;
  const auto side = [&](size_t i) -> Vector3 { return s.corners[(i + 1) % 3].point - s.corners[i].point; };
  size_t shortest = 0;
  for (size_t i = 1; i < 3; ++i) {
    if (side(i).squaredNorm() < side(shortest).squaredNorm()) shortest = i;
  }
  const Vector3 normal = side(shortest).cross(side((shortest + 2) % 3));
  const double square = normal.squaredNorm();
  if (!(square > 0)) return closest;
  return normal.dot(s.corners[shortest].point) / square * normal;
}

Vector3 Shrunk(const Solid& solid, const Vector3& point, double shrink) {
  return point + shrink * (solid.center() - point);
}

}  // namespace

CorePoints FindCorePoints(const Solid& a, const Solid& b, const Vector3& shift, double nothing, double shrink) {
  const auto support = [&](const Vector3& towards) {
    Corner corner;
    corner.on_a = Shrunk(a, a.Support(towards), shrink);
    corner.on_b = Shrunk(b, b.Support(-towards), shrink) + shift;
    corner.point = corner.on_a - corner.on_b;
    return corner;
  };
  Vector3 closest = a.center() - b.center() - shift;
  if (closest.squaredNorm() <= nothing * nothing) closest = Vector3::UnitX();
  Simplex simplex;
  double distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kIterationsMax; ++i) {
    const Corner corner = support(-closest);
    if (simplex.count > 0 && distance * distance - closest.dot(corner.point) <= kConverged * distance * distance) break;
    Simplex larger = simplex;
    larger.corners[larger.count++] = corner;
    const Simplex reduced = Reduced(larger);
    const Vector3 nearer = Across(reduced);
    const double length = nearer.norm();
    if (reduced.count == 4 || length <= nothing) return {};
    // Rounding has the last word: there is nothing nearer to find.
    if (length >= distance) break;
    simplex = reduced;
    closest = nearer;
    distance = length;
  }
  CorePoints points{.normal = -closest / distance, .distance = distance};
  for (size_t i = 0; i < simplex.count; ++i) {
    points.on_a += simplex.weights[i] * simplex.corners[i].on_a;
    points.on_b += simplex.weights[i] * simplex.corners[i].on_b;
  }
  return points;
}

}  // namespace genphys

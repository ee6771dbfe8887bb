#include "shapes/gjk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "shapes/turned_corners.h"

namespace genphys {
namespace {

constexpr int kIterationsMax = 100;
// Of what is round: after how many iterations Newton's method is asked, how many are in between, and how often it may
// fail.
constexpr int kFirstTurn = 5, kBetweenTurns = 4, kFailuresMax = 2;
// By this much a bound is beyond what is asked for, lest rounding decide.
constexpr double kSurely = 1 + 1e-9;
// Of the longest edge's cube: a tetrahedron with less volume has no inside.
constexpr double kFlat = 1e-13;

// Some corners of a simplex, and the weights by which they make up the point of their hull that is closest to the
// origin. It names them, for to copy them costs more than to work this out.
struct Part {
  std::array<double, 3> weights{};
  std::array<uint8_t, 3> corners{};
  uint8_t count = 0;  // zero: all four, and the origin is inside
  Vector3 closest = Vector3::Zero();
  double square = 0;  // of its distance
};

template <size_t N>
Part Pick(const Simplex& from, const std::array<size_t, N>& chosen, const std::array<double, N>& weights) {
  Part part;
  part.count = N;
  for (size_t i = 0; i < N; ++i) {
    part.corners[i] = static_cast<uint8_t>(chosen[i]);
    part.weights[i] = weights[i];
    part.closest += weights[i] * from.corners[chosen[i]].point;
  }
  part.square = part.closest.squaredNorm();
  return part;
}

Part ClosestOnSegment(const Simplex& s, size_t a, size_t b) {
  const Vector3& from = s.corners[a].point;
  const Vector3 edge = s.corners[b].point - from;
  const double along = -from.dot(edge), square = edge.squaredNorm();
  if (!(along > 0)) return Pick<1>(s, {a}, {1});
  if (along >= square) return Pick<1>(s, {b}, {1});
  return Pick<2>(s, {a, b}, {1 - along / square, along / square});
}

// By barycentric coordinates where the foot of the origin lies inside, else on the nearest edge.
Part ClosestOnTriangle(const Simplex& s, size_t a, size_t b, size_t c) {
  // From differences, which stay exact while the triangle shrinks far away from the origin.
  const Vector3& p = s.corners[a].point;
  const Vector3 q = s.corners[b].point - p, r = s.corners[c].point - p;
  const Vector3 normal = q.cross(r);
  const double square = normal.squaredNorm();
  const double at_q = r.cross(p).dot(normal), at_r = p.cross(q).dot(normal);
  if (at_q > 0 && at_r > 0 && at_q + at_r < square) {
    return Pick<3>(s, {a, b, c}, {1 - (at_q + at_r) / square, at_q / square, at_r / square});
  }
  Part nearest = ClosestOnSegment(s, a, b);
  for (const auto& [from, to] : {std::pair{b, c}, {c, a}}) {
    const Part other = ClosestOnSegment(s, from, to);
    if (other.square < nearest.square) nearest = other;
  }
  return nearest;
}

// None: the origin is inside.
Part ClosestOnTetrahedron(const Simplex& s) {
  static constexpr std::array<std::array<size_t, 4>, 4> kFaces{
      {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}}};
  const auto point = [&](size_t i) -> const Vector3& { return s.corners[i].point; };
  const double volume = (point(1) - point(0)).dot((point(2) - point(0)).cross(point(3) - point(0)));
  double longest = 0;
  for (size_t i = 0; i < 4; ++i) longest = std::max(longest, (point(i) - point((i + 1) % 4)).squaredNorm());
  const bool is_flat = std::abs(volume) <= kFlat * longest * std::sqrt(longest);
  Part best;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c, opposite] : kFaces) {
    const Vector3 normal = (point(b) - point(a)).cross(point(c) - point(a));
    const double origin_side = -normal.dot(point(a)), inner_side = normal.dot(point(opposite) - point(a));
    if (!is_flat && origin_side * inner_side >= 0) continue;
    const Part on_face = ClosestOnTriangle(s, a, b, c);
    if (on_face.square >= least) continue;
    least = on_face.square;
    best = on_face;
  }
  return best;
}

Part Reduced(const Simplex& s) {
  switch (s.count) {
    case 1:
      return Pick<1>(s, {0}, {1});
    case 2:
      return ClosestOnSegment(s, 0, 1);
    case 3:
      return ClosestOnTriangle(s, 0, 1, 2);
    default:
      return ClosestOnTetrahedron(s);
  }
}

// The closest point of a part once more, exactly across its edges: a weight that is off in its last digits is off by
// more of a long edge than a near origin is away.
Vector3 Across(const Simplex& s, const Part& part) {
  const auto point = [&](size_t i) -> const Vector3& { return s.corners[part.corners[i]].point; };
  if (part.count == 2) {
    const Vector3 edge = point(1) - point(0);
    return part.closest - part.closest.dot(edge) / edge.squaredNorm() * edge;
  }
  if (part.count != 3) return part.closest;
  const auto side = [&](size_t i) -> Vector3 { return point((i + 1) % 3) - point(i); };
  size_t shortest = 0;
  for (size_t i = 1; i < 3; ++i) {
    if (side(i).squaredNorm() < side(shortest).squaredNorm()) shortest = i;
  }
  const Vector3 normal = side(shortest).cross(side((shortest + 2) % 3));
  const double square = normal.squaredNorm();
  if (!(square > 0)) return part.closest;
  return normal.dot(point(shortest)) / square * normal;
}

// Leaves these corners alone, in this order.
void Keep(Simplex& simplex, const Part& part) {
  const std::array<Corner, 4> before = simplex.corners;
  for (size_t i = 0; i < part.count; ++i) simplex.corners[i] = before[part.corners[i]];
  simplex.count = part.count;
}

}  // namespace

Nearest FindNearest(const Solid& a, const Solid& b, const CoreQuery& query) {
  const auto support = [&](const Vector3& towards) {
    Corner corner;
    corner.on_a = query.Shrunk(a, a.Support(towards));
    corner.on_b = query.Shrunk(b, b.Support(-towards)) + query.shift;
    corner.point = corner.on_a - corner.on_b;
    return corner;
  };
  Vector3 direction = query.direction ? Vector3(-*query.direction) : a.center() - b.center() - query.shift;
  if (direction.squaredNorm() <= query.nothing * query.nothing) direction = Vector3::UnitX();
  int failures = a.is_round() || b.is_round() ? 0 : kFailuresMax;
  Nearest nearest{.closest = direction};
  Simplex& simplex = nearest.simplex;
  for (int i = 0; i < kIterationsMax; ++i) {
    const Corner corner = support(-nearest.closest);
    const double distance = nearest.distance;
    if (simplex.count > 0) {
      // No point of the difference lies nearer along this direction.
      const double along = nearest.closest.dot(corner.point);
      if (along > kSurely * query.distance_max * distance) break;
      if (distance * distance - along <= query.tolerance * distance * distance) break;
    }
    simplex.corners[simplex.count++] = corner;
    const Part part = Reduced(simplex);
    if (part.count == 0) return {};
    const Vector3 nearer = Across(simplex, part);
    const double length = nearer.norm();
    if (length <= query.nothing) return {};
    // Rounding has the last word: there is nothing nearer to find.
    if (length >= distance) {
      --simplex.count;
      break;
    }
    Keep(simplex, part);
    nearest.weights = part.weights;
    nearest.closest = nearer;
    nearest.distance = length;
    if (failures < kFailuresMax && i >= kFirstTurn && (i - kFirstTurn) % kBetweenTurns == 0) {
      failures += TurnCorners(a, b, query, nearest) ? 0 : 1;
    }
  }
  return nearest;
}

CorePoints FindCorePoints(const Solid& a, const Solid& b, const CoreQuery& query) {
  const Nearest nearest = FindNearest(a, b, query);
  if (nearest.overlaps()) return {};
  return {nearest.Sum(&Corner::on_a), nearest.Sum(&Corner::on_b), nearest.normal(), nearest.distance};
}

}  // namespace genphys

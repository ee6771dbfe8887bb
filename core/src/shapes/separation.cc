#include "shapes/separation.h"

#include <algorithm>

#include "shapes/turned_corners.h"

namespace genphys {
namespace {

// Parts of the smaller solid's size. Below the first gap the direction between closest points is lost to rounding.
constexpr double kNear = 1e-4;
// How far solids are moved apart to look for a better direction: as far as they overlap, within these.
constexpr double kApartMin = 1e-5;
constexpr double kApartMax = 1e-3;
constexpr double kNothing = 1e-9;
constexpr double kSettled = 1e-12;
// rad^2, of a turn: the next one is smaller by about the overlap's part of the size.
constexpr double kHardlyTurned = 1e-10;
// Of a squared distance: enough for a direction to start from.
constexpr double kRough = 1e-6;
// By this part smaller copies of overlapping solids are smaller.
constexpr double kShrink = 0.02;
constexpr int kTurnsMax = 24;

double SizeOf(const Solid& a, const Solid& b) { return std::min(a.size(), b.size()); }

// Of the solids, if that is of their cores.
Separation Rounded(const Solid& a, const Solid& b, const LeastOverlap& core) {
  const Vector3 on_a = core.on_a + a.radius() * core.normal, on_b = core.on_b - b.radius() * core.normal;
  return {core.normal, core.depth + a.radius() + b.radius(), (on_a + on_b) / 2};
}

CoreQuery QueryShrunk(const Solid& a, const Solid& b) {
  return {.nothing = kNothing * SizeOf(a, b), .shrink = kShrink, .tolerance = kRough};
}

// The separation of two without a radius that overlap little or are apart, if it is among those pieces of their
// surfaces where smaller copies of them are nearest.
std::optional<Separation> SeparationNear(const Solid& a, const Solid& b, double gap_max) {
  const CoreQuery query = QueryShrunk(a, b);
  const Nearest shrunk = FindNearest(a, b, query);
  if (shrunk.overlaps()) return std::nullopt;
  const double overlap = OverlapAlong(a, b, shrunk.normal());
  if (overlap < -gap_max) return Separation{.normal = shrunk.normal(), .depth = overlap};
  const std::optional<LeastOverlap> least = TurnToLeast(a, b, query, shrunk);
  if (!least || least->depth > overlap) return std::nullopt;
  return Rounded(a, b, *least);
}

}  // namespace

std::optional<Separation> SeparationApart(const Solid& a, const Solid& b, double gap_max) {
  const double near = kNear * SizeOf(a, b);
  const double core_gap_max = std::max(gap_max + a.radius() + b.radius(), 2 * near);
  const CorePoints core = FindCorePoints(a, b, {.nothing = near, .distance_max = core_gap_max});
  if (core.distance <= near) return std::nullopt;
  const Vector3 on_a = core.on_a + a.radius() * core.normal, on_b = core.on_b - b.radius() * core.normal;
  return Separation{core.normal, OverlapAlong(a, b, core.normal), (on_a + on_b) / 2};
}

// Moved along any direction by a little more than the overlap in it, b is apart from a. Whatever direction the closest
// points then have, the overlap in it is at most the one before: n.d s - f(n) = distance >= s - f(d) for a move of s.
Separation Descend(const Solid& a, const Solid& b, const Vector3& start) {
  const double size = SizeOf(a, b);
  LeastOverlap best{.normal = start, .on_a = a.Support(start), .on_b = b.Support(-start)};
  best.depth = start.dot(best.on_a - best.on_b);
  for (int i = 0; i < kTurnsMax; ++i) {
    const double apart = std::clamp(best.depth, kApartMin * size, kApartMax * size);
    const CoreQuery query{.shift = (std::max(best.depth, 0.0) + apart) * best.normal,
                          .nothing = kNothing * size,
                          .direction = best.normal};
    const Nearest nearest = FindNearest(a, b, query);
    if (nearest.overlaps()) break;
    const std::optional<LeastOverlap> least = TurnToLeast(a, b, query, nearest);
    if (least && least->depth <= best.depth) {
      best = *least;
      break;
    }
    const Vector3 turned = nearest.normal();
    best.on_a = nearest.Sum(&Corner::on_a);
    best.on_b = nearest.Sum(&Corner::on_b) - query.shift;
    const double depth = turned.dot(a.Support(turned) - b.Support(-turned));
    if (!(depth < best.depth)) break;
    const bool is_settled =
        best.depth - depth <= kSettled * size || (turned - best.normal).squaredNorm() <= kHardlyTurned;
    best.depth = depth;
    best.normal = turned;
    if (is_settled) break;
  }
  return Rounded(a, b, best);
}

std::optional<Separation> ShallowSeparation(const Solid& a, const Solid& b) {
  const CoreQuery query = QueryShrunk(a, b);
  const Nearest shrunk = FindNearest(a, b, query);
  if (shrunk.overlaps()) return std::nullopt;
  const std::optional<LeastOverlap> least = TurnToLeast(a, b, query, shrunk);
  return least ? Rounded(a, b, *least) : Descend(a, b, shrunk.normal());
}

Separation FindSeparation(const Solid& a, const Solid& b, double gap_max) {
  if (a.radius() == 0 && b.radius() == 0) {
    if (const auto near = SeparationNear(a, b, gap_max)) return *near;
  }
  if (const auto apart = SeparationApart(a, b, gap_max)) return *apart;
  if (const auto shallow = ShallowSeparation(a, b)) return *shallow;
  const Vector3 between = b.center() - a.center();
  Vector3 best = between.norm() > kNothing * SizeOf(a, b) ? between.normalized() : Vector3::UnitZ();
  double least = OverlapAlong(a, b, best);
  const auto consider = [&](const Vector3& direction) {
    const double overlap = OverlapAlong(a, b, direction);
    if (overlap < least) least = overlap, best = direction;
  };
  a.VisitNormals(b.center(), consider);
  b.VisitNormals(a.center(), [&](const Vector3& direction) { consider(-direction); });
  return Descend(a, b, best);
}

}  // namespace genphys

#include "shapes/separation.h"

#include <algorithm>

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
constexpr double kRough = 1e-4;
// By this part smaller copies of overlapping solids are smaller.
constexpr double kShrink = 0.02;
constexpr int kTurnsMax = 24;

double SizeOf(const Solid& a, const Solid& b) { return std::min(a.size(), b.size()); }

}  // namespace

std::optional<Separation> SeparationApart(const Solid& a, const Solid& b, double gap_max) {
  const double near = kNear * SizeOf(a, b);
  const double core_gap_max = std::max(gap_max + a.radius() + b.radius(), 2 * near);
  const CorePoints core = FindCorePoints(a, b, {.nothing = near, .distance_max = core_gap_max});
  if (core.distance <= near) return std::nullopt;
  const Vector3 on_a = core.on_a + a.radius() * core.normal, on_b = core.on_b - b.radius() * core.normal;
  return Separation{core.normal, OverlapAlong(a, b, core.normal), (on_a + on_b) / 2};
}

std::optional<Vector3> ShallowDirection(const Solid& a, const Solid& b) {
  const double nothing = kNothing * SizeOf(a, b);
  const CorePoints core = FindCorePoints(a, b, {.nothing = nothing, .shrink = kShrink, .tolerance = kRough});
  if (!(core.distance > 0)) return std::nullopt;
  return core.normal;
}

// Moved along any direction by a little more than the overlap in it, b is apart from a. Whatever direction the closest
// points then have, the overlap in it is at most the one before: n.d s - f(n) = distance >= s - f(d) for a move of s.
Separation Descend(const Solid& a, const Solid& b, const Vector3& start) {
  const double size = SizeOf(a, b);
  const auto core_overlap = [&](const Vector3& n) { return n.dot(a.Support(n)) - n.dot(b.Support(-n)); };
  Separation best{.normal = start};
  double overlap = core_overlap(start);
  Vector3 on_a = a.Support(start), on_b = b.Support(-start);
  for (int i = 0; i < kTurnsMax; ++i) {
    const double apart = std::clamp(overlap, kApartMin * size, kApartMax * size);
    const Vector3 shift = (std::max(overlap, 0.0) + apart) * best.normal;
    const CorePoints core =
        FindCorePoints(a, b, {.shift = shift, .nothing = kNothing * size, .direction = best.normal});
    if (!(core.distance > 0)) break;
    on_a = core.on_a;
    on_b = core.on_b - shift;
    const double turned = core_overlap(core.normal);
    if (!(turned < overlap)) break;
    const bool is_settled =
        overlap - turned <= kSettled * size || (core.normal - best.normal).squaredNorm() <= kHardlyTurned;
    overlap = turned;
    best.normal = core.normal;
    if (is_settled) break;
  }
  best.depth = overlap + a.radius() + b.radius();
  best.place = (on_a + a.radius() * best.normal + on_b - b.radius() * best.normal) / 2;
  return best;
}

Separation FindSeparation(const Solid& a, const Solid& b, double gap_max) {
  if (const auto apart = SeparationApart(a, b, gap_max)) return *apart;
  if (const auto shallow = ShallowDirection(a, b)) return Descend(a, b, *shallow);
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

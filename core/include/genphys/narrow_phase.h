#pragma once
#include <array>

#include "genphys/placement.h"
#include "genphys/shape.h"

namespace genphys {

/// A point where two solids meet, half-way between their surfaces.
struct MeetingPoint {
  Vector3 position = Vector3::Zero();
  Vector3 normal = Vector3::Zero();  // unit length, from a to b
  double depth = 0;                  // m; negative is a gap
};

/// The points in which one pair of shapes meets: up to four for each direction in which a surface pushes.
struct Manifold {
  static constexpr int kPointsPerNormal = 4;
  static constexpr int kPointsMax = 16;

  std::array<MeetingPoint, kPointsMax> points;
  int count = 0;

  void Add(const MeetingPoint& point) {
    if (count < kPointsMax) points[static_cast<size_t>(count++)] = point;
  }
};

/// Whether this pair belongs to FindContacts(). Engines have cones, ellipsoids, hulls, meshes and heightfields in part,
/// with margins, in single precision or not at all, and where a capsule or a cylinder meets something with edges they
/// give one point where there are more, or a normal that is off. Of two boxes Bullet knows one point for sure, and ODE
/// takes some that lie flat on each other to be apart, and others to meet now here, now there along an edge: with its
/// points 1,000 boxes in a pile overlap by 0.03 mm in the mean, with these by less than 0.001, and take 1.5 times as
/// long. Of a drum that does not stand quite straight on a plane ODE tells one point, however near the rest of its rim
/// is, and what lies on it then tips it over that point before there is another one. Balls, and boxes and capsules on
/// planes, they do well.
bool IsForNarrowPhase(const Shape& a, const Shape& b);

/// Where `a` and `b` meet at these placements; points with a gap of more than `gap` (m) are left out. A function of its
/// arguments alone: depths are exact to rounding for polyhedra and planes and to 1e-9 of the size for round shapes.
/// Boxes that overlap are parted along a face rather than across edges, if that takes at most a twentieth more, `gap`
/// included: what lies flat shall not turn with the last bit. Two planes never meet.
void FindContacts(const Shape& a, const Placement& placement_a, const Shape& b, const Placement& placement_b,
                  double gap, Manifold& manifold);

}  // namespace genphys

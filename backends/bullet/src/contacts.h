#pragma once
#include <array>

#include "shapes.h"

namespace genphys::bullet_backend {

/// A point where two solids meet, half-way between their surfaces.
struct MeetingPoint {
  Vector3 position = Vector3::Zero();  // world
  Vector3 normal = Vector3::Zero();    // unit length, from a to b, world
  double depth = 0;                    // m; negative is a gap
};

/// The points of one pair, as many as Bullet's solver takes.
struct Meeting {
  static constexpr int kPointsMax = 4;
  std::array<MeetingPoint, kPointsMax> points;
  int count = 0;
};

/// Finds where `a` and `b` meet at these placements, with nothing remembered from before. Points with a gap of more
/// than kContactGap are left out.
void FindMeeting(const CollisionShape& a, const Placement& placement_a, const CollisionShape& b,
                 const Placement& placement_b, Meeting& meeting);

}  // namespace genphys::bullet_backend

#include "impacts/impact_speed.h"

#include <algorithm>
#include <cmath>

namespace genphys {
namespace {

// Of what that is in a substep: a hop from there to and fro takes twice as long as this part of it, and all hops after
// it together are left out.
constexpr double kShortestHop = 0.25;

}  // namespace

bool ImpactSpeed::IsInFlight(EntityRow row) const {
  return !world_.active[Index(row)] || world_.layer.half_steps[Index(row)].in_flight;
}

double ImpactSpeed::Of(EntityRow a, EntityRow b, const Vector3& normal) const {
  const double pull_a = world_.accelerations[a].dot(normal), pull_b = world_.accelerations[b].dot(normal);
  if (IsInFlight(a) && IsInFlight(b)) return kMin + kShortestHop * std::abs(pull_b - pull_a) * step_size_;
  return kMin + 2 * std::max(std::abs(pull_a), std::abs(pull_b)) * step_size_;
}

bool ImpactSpeed::IsMovable(EntityRow row, GeometryRow geometry) const {
  return world_.active[Index(row)] && world_.rule.info(geometry).is_dynamic;
}

bool ImpactSpeed::IsFree(const ContactPair& pair) const {
  const auto flew = [&](EntityRow row, GeometryRow geometry) { return IsMovable(row, geometry) && world_.flew[row]; };
  return IsStillFree(pair) || flew(pair.entity_a, pair.geometry_a) || flew(pair.entity_b, pair.geometry_b);
}

bool ImpactSpeed::IsStillFree(const ContactPair& pair) const {
  const auto flies = [&](EntityRow row, GeometryRow geometry) {
    return IsMovable(row, geometry) && world_.layer.half_steps[Index(row)].in_flight;
  };
  return flies(pair.entity_a, pair.geometry_a) || flies(pair.entity_b, pair.geometry_b);
}

}  // namespace genphys

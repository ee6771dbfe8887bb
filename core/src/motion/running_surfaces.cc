#include "motion/running_surfaces.h"

#include <algorithm>

namespace genphys {

Vector3 SurfaceVelocity(const PairRule& rule, const StateArrays& state, GeometryRow a, GeometryRow b) {
  const auto velocity = [&](GeometryRow row) -> Vector3 {
    const PairRule::GeometryInfo& info = rule.info(row);
    if (info.surface_velocity.isZero(0)) return Vector3::Zero();
    return state.pose(info.entity).orientation * info.surface_velocity;
  };
  return velocity(b) - velocity(a);
}

void FillSurfaceVelocities(const PairRule& rule, const StateArrays& state, ContactBuffer& contacts) {
  if (!rule.any_surface_runs()) return;
  for (ContactPair& pair : contacts.pairs) {
    pair.surface_velocity = SurfaceVelocity(rule, state, pair.geometry_a, pair.geometry_b);
  }
}

bool HasRunningSurface(const RigidBody& body) {
  return std::any_of(body.geometries.begin(), body.geometries.end(),
                     [](const Geometry& geometry) { return !geometry.surface_velocity.isZero(0); });
}

}  // namespace genphys

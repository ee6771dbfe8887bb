#include "motion/running_surfaces.h"

#include <algorithm>

namespace genphys {

void FillSurfaceVelocities(const PairRule& rule, const StateArrays& state, ContactBuffer& contacts) {
  if (!rule.any_surface_runs()) return;
  const auto velocity = [&](GeometryRow row) -> Vector3 {
    const PairRule::GeometryInfo& info = rule.info(row);
    if (info.surface_velocity.isZero(0)) return Vector3::Zero();
    return state.pose(info.entity).orientation * info.surface_velocity;
  };
  for (ContactPair& pair : contacts.pairs) {
    pair.surface_velocity = velocity(pair.geometry_b) - velocity(pair.geometry_a);
  }
}

bool HasRunningSurface(const RigidBody& body) {
  return std::any_of(body.geometries.begin(), body.geometries.end(),
                     [](const Geometry& geometry) { return !geometry.surface_velocity.isZero(0); });
}

}  // namespace genphys

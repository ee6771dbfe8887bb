#pragma once
#include <memory>

#include "scene.h"
#include "simulation.h"

namespace genphys::bench {

/// `scene` in a world of Bullet's own, in double precision, as its manual sets one up, all parameters at their
/// defaults.
std::unique_ptr<Simulation> SimulateInRawBullet(const Scene& scene);

}  // namespace genphys::bench

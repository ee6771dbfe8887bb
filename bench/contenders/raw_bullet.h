#pragma once
#include <memory>
#include <optional>

#include "scene.h"
#include "simulation.h"

namespace genphys::bench {

/// How a world of Bullet is set up; what is left out is as its manual has it.
struct BulletSetup {
  bool updates_all_boxes = true;  // of sleepers and static bodies too, at every step
  bool is_continuous = true;      // collision detection looks ahead
  bool splits_islands = true;     // and does not solve all of them as one
  std::optional<int> pool_size;   // of manifolds and of algorithms, allocated at once
};

/// `scene` in a world of Bullet's own, in double precision, all other parameters at their defaults.
std::unique_ptr<Simulation> SimulateInRawBullet(const BulletSetup& setup, const Scene& scene);

}  // namespace genphys::bench

#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "genphys/world.h"
#include "support/random.h"

namespace genphys::testing {

/// A world full of whatever a seed says, and apart from its crowd some that are known to rest, hang or fly.
struct RandomScene {
  std::unique_ptr<World> world;
  std::vector<EntityId> sleepers;  // lie still at once and fall asleep within a quarter of a second
  JointId hook;                    // of a pendulum; null if there are no ball joints
  EntityId flyer;                  // floats, pushed by one pending force and nothing else
  Vector3 push = Vector3::Zero();  // of the flyer, m/s^2
  uint32_t push_steps = 0;
};

/// Shapes, joints, filters, motion types, masses of 1e-3 to 1e3 kg, fields and pending forces at random, of what all
/// `engines` (short names) can do; the world starts on the first of them.
RandomScene MakeRandomScene(const std::vector<std::string>& engines, uint64_t seed);

}  // namespace genphys::testing

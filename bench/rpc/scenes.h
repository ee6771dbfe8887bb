#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "genphys/entity.h"
#include "genphys/scene.h"

namespace genphys::bench {

/// What is simulated while the cost of a step is measured. A world of it is the same wherever it is made.
struct Scene {
  std::string name;
  WorldDesc world;
  std::vector<EntityDesc> entities;
  uint32_t steps_before = 0;    // until it is what its name says
  bool ends_up_asleep = false;  // after steps_before all dynamic entities must sleep
};

inline constexpr uint32_t kSceneEntities = 1000;

/// A pile of `boxes` that never sleeps, once it has fallen.
Scene PileOf(const std::string& engine, uint32_t boxes);

/// 1,000 boxes that have come to rest on a floor and sleep, 1,000 that fly and touch nothing, and a pile of 1,000 that
/// never sleeps, on `engine`.
std::vector<Scene> Scenes(const std::string& engine);

}  // namespace genphys::bench

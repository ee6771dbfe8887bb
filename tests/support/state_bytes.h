#pragma once
#include <string>

#include "core/src/model/state_hash.h"
#include "genphys/world.h"

namespace genphys::testing {

/// All that makes a world what it is, but what the engine keeps to itself.
inline std::string AllButTheEngineOf(const World& world) {
  std::string bytes;
  Serialize(world.scene(), bytes);
  Serialize(world.state(), bytes);
  Serialize(world.layer_state(), bytes);
  return bytes;
}

}  // namespace genphys::testing

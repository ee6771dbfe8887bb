#pragma once
#include "genphys/world.h"

namespace genphys {

/// What a world was at its beginning: what a reset brings back.
struct World::Initial {
  Scene scene;
  StateArrays state;
  LayerState layer;
};

}  // namespace genphys

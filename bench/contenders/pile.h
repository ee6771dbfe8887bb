#pragma once
#include <cstdint>

#include "scene.h"

namespace genphys::bench {

struct PileOptions {
  int row = 10;
  int layers = 10;    // of row * row cubes
  double rise = 1.1;  // m, from one layer to the next
  double restitution = 0;
  uint32_t seed = 1;  // of the disorder
};

/// Layers of unit cubes in slight disorder that fall on each other: a pile and no columns.
Scene PileOf(const PileOptions& options);

}  // namespace genphys::bench

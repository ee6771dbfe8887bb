#pragma once
#include "genphys/world.h"

namespace genphys::testing {

/// J, of all that moves.
double KineticEnergyOf(const World& world);

}  // namespace genphys::testing

#pragma once
#include "genphys/world.h"

namespace genphys::testing {

/// J, of all that moves.
double KineticEnergyOf(const World& world);

/// kg*m/s, of all that moves, which has a mass.
Vector3 MomentumOf(const World& world);

/// kg*m^2/s about the origin, of all that moves, which has a mass.
Vector3 AngularMomentumOf(const World& world);

}  // namespace genphys::testing

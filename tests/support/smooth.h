#pragma once
#include <memory>
#include <string>

#include "genphys/entity.h"
#include "genphys/stepper.h"
#include "genphys/world.h"

namespace genphys::testing {

/// `body`, the first geometry of which rubs nothing and bounces off what it meets with `restitution`.
EntityDesc Smooth(EntityDesc body, double restitution);

/// A floor under 9.81 m/s^2, stepped by 1/60 s. With `sleeps` what rests for a tenth of a second is asleep.
std::unique_ptr<World> FloorOf(const std::string& engine, bool sleeps, Quality quality = Quality::kBalanced);

}  // namespace genphys::testing

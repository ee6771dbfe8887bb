#pragma once
#include <memory>

#include "scene.h"
#include "simulation.h"

namespace genphys::bench {

/// ODE's steppers: one solves exactly, the other sweeps 20 times.
enum class OdeStepper { kWorldStep, kQuickStep };

/// `scene` in a world of ODE's own, as its manual and demonstrations set one up, all parameters at their defaults:
/// contacts by a callback, up to 8 a pair, friction in the approximation of the pyramid, sweep-and-prune space.
std::unique_ptr<Simulation> SimulateInRawOde(OdeStepper stepper, const Scene& scene);

}  // namespace genphys::bench

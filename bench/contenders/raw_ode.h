#pragma once
#include <memory>

#include "scene.h"
#include "simulation.h"

namespace genphys::bench {

/// ODE's steppers: one solves exactly, the other sweeps 20 times.
enum class OdeStepper { kWorldStep, kQuickStep };

/// ODE's ways to find who is near whom: sweep and prune along one axis, the others looked at in this order, or grids.
enum class OdeSpace { kSweepXyz, kSweepXzy, kHash };

/// How a world of ODE is set up; what is left out is as its manual and demonstrations have it.
struct OdeSetup {
  OdeStepper stepper = OdeStepper::kQuickStep;
  OdeSpace space = OdeSpace::kSweepXyz;
  int contacts_max = 8;  // of a pair
};

/// `scene` in a world of ODE's own, all parameters at their defaults: contacts by a callback, friction in the
/// approximation of the pyramid.
std::unique_ptr<Simulation> SimulateInRawOde(const OdeSetup& setup, const Scene& scene);

}  // namespace genphys::bench

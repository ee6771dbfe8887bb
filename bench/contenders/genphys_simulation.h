#pragma once
#include <memory>
#include <string>

#include "genphys/registry.h"
#include "genphys/stepper.h"
#include "scene.h"
#include "simulation.h"

namespace genphys::bench {

/// `scene` in a world of our model, no events recorded. `registry` must outlive it.
std::unique_ptr<Simulation> SimulateInGenphys(const BackendRegistry& registry, const std::string& engine,
                                              const StepperDesc& stepper, const Scene& scene);

}  // namespace genphys::bench

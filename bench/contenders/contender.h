#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "genphys/registry.h"
#include "genphys/stepper.h"
#include "scene.h"
#include "simulation.h"

namespace genphys::bench {

/// A way to simulate a scene.
struct Contender {
  std::string name;    // "genphys-ode-balanced", "raw-ode-quick"
  std::string engine;  // "ode" or "bullet", below or alone
  std::function<std::unique_ptr<Simulation>(const Scene&)> start;
};

/// Our model on each engine that knows contacts, with each preset, and the engines alone. `engine_only` leaves every
/// body of our model to the engine.
std::vector<Contender> Contenders(const BackendRegistry& registry, bool engine_only = false);

/// Our model at each of the settings among which the presets were chosen: "genphys-ode-2" has 2 substeps with as many
/// iterations as the presets have, and "genphys-ode-2x40" has 40 in each.
std::vector<Contender> FrontierContenders(const BackendRegistry& registry);

/// Our model with any stepper, under a name of its own. `registry` must outlive it.
Contender GenphysContender(const BackendRegistry& registry, const std::string& name, const std::string& engine,
                           const StepperDesc& stepper);

/// The engines alone in their defaults, and then set up for speed in the ways that they have for it: where the fastest
/// is looked for.
std::vector<Contender> RawContenders(const std::string& engine);

}  // namespace genphys::bench

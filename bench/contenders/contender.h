#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "genphys/registry.h"
#include "scene.h"
#include "simulation.h"

namespace genphys::bench {

/// A way to simulate a scene.
struct Contender {
  std::string name;    // "genphys-ode-balanced", "raw-ode-quick"
  std::string engine;  // "ode" or "bullet", below or alone
  std::function<std::unique_ptr<Simulation>(const Scene&)> start;
};

/// Our model on each engine that knows contacts, with each preset, and the engines alone.
std::vector<Contender> Contenders(const BackendRegistry& registry);

}  // namespace genphys::bench

#pragma once
#include <cstddef>
#include <memory>
#include <vector>

#include "contenders/scene.h"
#include "contenders/simulation.h"
#include "genphys/registry.h"

namespace genphys::bench {

/// What can be said of a simulation by where its bodies are and how fast: a cheap one that is wrong is seen here.
struct Sight {
  size_t lost = 0;     // bodies that are nowhere, or below all that there is
  double overlap = 0;  // m, the deepest of two bodies that are not joined
  double gap = 0;      // m, the widest of balls and hinges; no number if bodies are lost
  double speed = 0;    // m/s, mean of all that move
};

/// Looks at the simulations of one scene: the same way, whoever simulates.
class Observer {
 public:
  /// Bodies whose centre is lower than `lowest` (m) are lost. `registry` and `scene` must outlive it.
  Observer(const BackendRegistry& registry, const Scene& scene, double lowest);

  Sight Look(const Simulation& simulation) const;

 private:
  double OverlapOf(const std::vector<Pose>& poses, const std::vector<bool>& lost) const;

  const BackendRegistry& registry_;
  const Scene& scene_;
  double lowest_;
  std::vector<double> radii_;                      // about the origin of a body, m
  std::vector<std::pair<size_t, size_t>> joined_;  // ascending
};

}  // namespace genphys::bench

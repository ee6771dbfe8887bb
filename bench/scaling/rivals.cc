#include "rivals.h"

#include <algorithm>
#include <cstdio>

namespace genphys::bench {

void Rivals::Add(const Contender& contender, const Scene& scene, uint32_t steps,
                 const std::function<void(Simulation&)>& prepare) {
  std::fprintf(stderr, "%s: %zu bodies, %u steps first\n", contender.name.c_str(), scene.bodies.size(), steps);
  Simulation& simulation = *simulations_.emplace_back(contender.start(scene));
  for (uint32_t i = 0; i < steps; ++i) simulation.Step(kStepSize);
  Party party{.series = contender.name,
              .name = contender.name,
              .size = static_cast<double>(scene.bodies.size()),
              .step = [&simulation] { simulation.Step(kStepSize); },
              .explain = [&simulation] { return simulation.Explain(kStepSize); }};
  if (prepare) party.prepare = [&simulation, prepare](uint32_t) { prepare(simulation); };
  parties_.push_back(party);
}

void Rivals::AddRaw(const Scene& scene, uint32_t steps, const std::function<void(Simulation&)>& prepare) {
  for (const Contender& contender : RawContenders(bench_.engine)) {
    raw_.push_back(parties_.size());
    Add(contender, scene, steps, prepare);
  }
}

size_t Rivals::fastest(const Race& race) const {
  return *std::ranges::min_element(raw_, {}, [&](size_t place) { return Median(race.costs[place]); });
}

}  // namespace genphys::bench

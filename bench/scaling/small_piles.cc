// Contacts of few bodies: many worlds, each of which holds a pile that leans, falls over or rests.
#include <cstdio>
#include <memory>

#include "case.h"
#include "contenders/contender.h"
#include "contenders/pile.h"
#include "rivals.h"

namespace genphys::bench {
namespace {

constexpr int kPiles = 40;
// What falls has fallen then; some lean and slide for longer.
constexpr uint32_t kStepsBefore = 240;

// Of 16 to 72 boxes: two or three in a row, four to eight high.
std::vector<Scene> Piles() {
  std::vector<Scene> piles;
  for (int i = 0; i < kPiles; ++i) {
    piles.push_back(PileOf({.row = 2 + i % 2, .layers = 4 + i % 5, .seed = static_cast<uint32_t>(i) + 1}));
  }
  return piles;
}

// One party that steps a world of each scene.
Party StepsAll(const Contender& contender, const std::vector<Scene>& scenes) {
  std::fprintf(stderr, "%s: %zu piles, %u steps first\n", contender.name.c_str(), scenes.size(), kStepsBefore);
  auto simulations = std::make_shared<std::vector<std::unique_ptr<Simulation>>>();
  double bodies = 0;
  for (const Scene& scene : scenes) {
    Simulation& simulation = *simulations->emplace_back(contender.start(scene));
    for (uint32_t i = 0; i < kStepsBefore; ++i) simulation.Step(kStepSize);
    bodies += static_cast<double>(scene.bodies.size());
  }
  const auto step = [simulations] {
    for (const auto& simulation : *simulations) simulation->Step(kStepSize);
  };
  return {.series = contender.name, .name = contender.name, .size = bodies, .step = step};
}

}  // namespace

Outcome MeasureSmallPiles(const Bench& bench) {
  const std::vector<Scene> scenes = Piles();
  const std::string ours = "genphys-" + bench.engine;
  const Contender alone = RawContenders(bench.engine).front();
  const std::vector<Party> parties = {
      StepsAll(GenphysContender(bench.registry, ours + "-fast", bench.engine, {.quality = Quality::kFast}), scenes),
      StepsAll(GenphysContender(bench.registry, ours + "-balanced", bench.engine, {}), scenes),
      StepsAll(alone, scenes),
  };
  const Race race = TakeTurns(parties, bench.plan, bench.engine + " small piles");
  Outcome outcome = Describe("small", bench.engine, parties, race);
  outcome.figures.push_back({.name = "fast / defaults, " + alone.name, .value = SpreadOf(race.Ratios(0, 2))});
  outcome.figures.push_back({.name = "balanced / defaults, " + alone.name, .value = SpreadOf(race.Ratios(1, 2))});
  return outcome;
}

}  // namespace genphys::bench

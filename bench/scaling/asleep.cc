// A world in which nothing moves.
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "case.h"
#include "local_world.h"

namespace genphys::bench {
namespace {

constexpr std::array<size_t, 4> kCounts{100, 1'000, 10'000, 100'000};
// Bar, us, whatever the number.
constexpr double kStepMax = 1;

std::vector<EntityDesc> Grid(size_t count) {
  constexpr double kSpacing = 1.5;  // m, of boxes of 1 m
  const auto row = static_cast<size_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  std::vector<EntityDesc> boxes;
  for (size_t i = 0; i < count; ++i) {
    boxes.push_back(
        BoxOf(kSpacing * Vector3(static_cast<double>(i % row), static_cast<double>(i / row), 0) + Vector3(0, 0, 0.5)));
  }
  return boxes;
}

}  // namespace

Outcome MeasureAsleep(const Bench& bench) {
  // They are put where they lie, so that nothing is left to wait for.
  constexpr double kRestTime = 0.05;
  WorldDesc desc{.engine = bench.engine};
  desc.default_auto_disable.rest_time = kRestTime;
  std::vector<std::unique_ptr<LocalWorld>> worlds;
  std::vector<Party> parties;
  for (const size_t count : kCounts) {
    const std::string name = WithCommas(count) + " asleep";
    std::fprintf(stderr, "%s asleep: %s\n", bench.engine.c_str(), name.c_str());
    LocalWorld& local = *worlds.emplace_back(std::make_unique<LocalWorld>(bench.registry, desc, Grid(count)));
    local.AwaitSleep(count);
    parties.push_back({.series = "all asleep",
                       .name = name,
                       .size = static_cast<double>(count),
                       .step = [&local] { local.Step(); },
                       .explain = [&local] { return local.Explain(); }});
  }
  const Race race = TakeTurns(parties, bench.plan, bench.engine + " asleep");
  Outcome outcome = Describe("asleep", bench.engine, parties, race);
  for (size_t i = 0; i < parties.size(); ++i) {
    if (worlds[i]->asleep() != kCounts[i]) throw std::runtime_error("somebody woke by himself");
    outcome.figures.push_back(
        {.name = parties[i].name, .unit = "µs", .value = outcome.costs[i].step, .at_most = kStepMax});
  }
  return outcome;
}

}  // namespace genphys::bench

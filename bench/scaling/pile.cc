// Contacts, which is what an engine is for: ours on it against the engine alone.
#include "contenders/pile.h"

#include <cmath>
#include <stdexcept>

#include "case.h"
#include "rivals.h"

namespace genphys::bench {
namespace {

// Bars for settings equal to those of the engine alone: against its defaults, and against the fastest setup of it.
constexpr double kToNaiveOdeMax = 1.0;
constexpr double kToNaiveBulletMax = 1.15;
constexpr double kToFastestMax = 1.15;

// What the engines alone do in a step, in their defaults.
constexpr uint32_t kOdeIterations = 20;
constexpr uint32_t kBulletIterations = 10;

// It falls, tumbles and has come to rest after this; it would sleep then.
constexpr uint32_t kStepsBefore = 600;
// Bar: m/s, of all boxes as the root of the mean square. A pile that still falls is no comparison, and neither is one
// of which boxes are thrown off.
constexpr double kSpeedMax = 0.1;

StepperDesc EqualTo(const std::string& engine) {
  return {.quality = Quality::kFast,
          .solver = Solver::kIterative,
          .substeps = 1,
          .iterations = engine == "ode" ? kOdeIterations : kBulletIterations};
}

double SpeedIn(const Simulation& simulation, size_t bodies) {
  double sum = 0;
  for (size_t body = 0; body < bodies; ++body) sum += simulation.MotionOf(body).velocity.squaredNorm();
  return std::sqrt(sum / static_cast<double>(bodies));
}

}  // namespace

Outcome MeasurePile(const Bench& bench) {
  const Scene scene = PileOf({});
  const std::string name = "genphys-" + bench.engine;
  Rivals rivals(bench);
  rivals.Add(GenphysContender(bench.registry, name + "-equal", bench.engine, EqualTo(bench.engine)), scene,
             kStepsBefore);
  rivals.Add(GenphysContender(bench.registry, name + "-balanced", bench.engine, {}), scene, kStepsBefore);
  rivals.AddRaw(scene, kStepsBefore);
  const Race race = TakeTurns(rivals.parties(), bench.plan, bench.engine + " pile");
  Outcome outcome = Describe("pile", bench.engine, rivals.parties(), race);
  const size_t fastest = rivals.fastest(race);
  const auto add = [&](const std::string& ours, size_t place, const std::string& whose, size_t other,
                       std::optional<double> most) {
    outcome.figures.push_back({.name = ours + " / " + whose + ", " + rivals.parties()[other].name,
                               .value = SpreadOf(race.Ratios(place, other)),
                               .at_most = most});
  };
  add("equal settings", 0, "defaults", rivals.naive(), bench.engine == "ode" ? kToNaiveOdeMax : kToNaiveBulletMax);
  add("equal settings", 0, "fastest alone", fastest, kToFastestMax);
  add("balanced", 1, "defaults", rivals.naive(), std::nullopt);
  add("balanced", 1, "fastest alone", fastest, std::nullopt);
  std::vector<double> speeds;
  for (size_t i = 0; i < rivals.parties().size(); ++i) {
    speeds.push_back(SpeedIn(rivals.simulation(i), scene.bodies.size()));
  }
  outcome.figures.push_back(
      {.name = "speed left in the piles", .unit = "m/s", .value = SpreadOf(speeds), .at_most = kSpeedMax});
  return outcome;
}

}  // namespace genphys::bench

// Bodies that nothing touches, while collisions are looked for.
#include <functional>
#include <stdexcept>
#include <utility>

#include "case.h"
#include "contenders/dice.h"
#include "rivals.h"

namespace genphys::bench {
namespace {

constexpr size_t kCount = 10'000;
// Bars, ns per body and step: a sphere turns about one axis, a box with three different sides tumbles.
constexpr double kSphereMax = 300;
constexpr double kBoxMax = 500;

// In a lattice that widens, so that gaps only grow.
Scene FlyersOf(const Shape& shape) {
  constexpr size_t kRow = 22;
  constexpr double kSpacing = 3;   // m
  constexpr double kSpread = 0.1;  // 1/s
  Scene scene;
  Dice dice(1);
  for (size_t i = 0; i < kCount; ++i) {
    const Vector3 place(static_cast<double>(i % kRow), static_cast<double>(i / kRow % kRow),
                        static_cast<double>(i / kRow / kRow));
    const Vector3 from_middle = kSpacing * (place - Vector3::Constant((kRow - 1) / 2.0));
    scene.Add(shape, 1, {.position = from_middle}, kSpread * from_middle, dice.NextVector());
  }
  return scene;
}

// What falls for long gets so fast that it flies past its neighbours in one step: gravity turns round with each turn.
std::function<void(Simulation&)> GravityThatTurns() {
  return [gravity = kGravity](Simulation& simulation) mutable {
    simulation.SetGravity({0, 0, gravity});
    gravity = -gravity;
  };
}

void Measure(const Bench& bench, const std::string& what, const Shape& shape, double most, Outcome& outcome) {
  constexpr uint32_t kStepsBefore = 10;
  const Scene scene = FlyersOf(shape);
  Rivals rivals(bench);
  rivals.Add(GenphysContender(bench.registry, "genphys-" + bench.engine + "-balanced", bench.engine, {}), scene,
             kStepsBefore, GravityThatTurns());
  rivals.AddRaw(scene, kStepsBefore, GravityThatTurns());
  const Race race = TakeTurns(rivals.parties(), bench.plan, bench.engine + " flyers, " + what);
  Outcome found = Describe("flyers", bench.engine, rivals.parties(), race);
  std::vector<double> each;
  for (const double cost : race.costs.front()) each.push_back(1e3 * cost / static_cast<double>(kCount));
  found.figures = {{.name = "one of " + what, .unit = "ns", .value = SpreadOf(each), .at_most = most},
                   {.name = what + ", balanced / " + rivals.parties()[rivals.naive()].name,
                    .value = SpreadOf(race.Ratios(0, rivals.naive()))},
                   {.name = what + ", balanced / fastest alone, " + rivals.parties()[rivals.fastest(race)].name,
                    .value = SpreadOf(race.Ratios(0, rivals.fastest(race)))}};
  if (found.costs.front().lanes->entities_in_flight != kCount) throw std::runtime_error("not all of them fly");
  for (Cost& cost : found.costs) cost.name = what + ", " + cost.name;
  Append(std::move(found), outcome);
}

}  // namespace

Outcome MeasureFlyers(const Bench& bench) {
  Outcome outcome{.scene = "flyers", .engine = bench.engine};
  Measure(bench, "spheres", Sphere{.radius = 0.5}, kSphereMax, outcome);
  Measure(bench, "boxes", Box{{0.5, 0.4, 0.3}}, kBoxMax, outcome);
  return outcome;
}

}  // namespace genphys::bench

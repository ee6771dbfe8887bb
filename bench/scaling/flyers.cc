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

// So that they go about among each other, and not all down.
std::function<void(Simulation&)> GravityThatTurns() {
  return [gravity = kGravity](Simulation& simulation) mutable {
    simulation.SetGravity({0, 0, gravity});
    gravity = -gravity;
  };
}

struct Kind {
  std::string what;
  Shape shape;
  double most = 0;  // ns
  bool is_falling = false;
};

void Measure(const Bench& bench, const Kind& kind, Outcome& outcome) {
  const std::string& what = kind.what;
  // Who has fallen for two seconds flies past its neighbours in ten more steps.
  const uint32_t steps_before = kind.is_falling ? 120 : 10;
  const auto prepare = kind.is_falling ? std::function<void(Simulation&)>() : GravityThatTurns();
  const Scene scene = FlyersOf(kind.shape);
  Rivals rivals(bench);
  rivals.Add(GenphysContender(bench.registry, "genphys-" + bench.engine + "-balanced", bench.engine, {}), scene,
             steps_before, prepare);
  rivals.AddRaw(scene, steps_before, prepare);
  const Race race = TakeTurns(rivals.parties(), bench.plan, bench.engine + " flyers, " + what);
  Outcome found = Describe("flyers", bench.engine, rivals.parties(), race);
  std::vector<double> each;
  for (const double cost : race.costs.front()) each.push_back(1e3 * cost / static_cast<double>(kCount));
  found.figures = {{.name = "one of " + what, .unit = "ns", .value = SpreadOf(each), .at_most = kind.most},
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
  const Shape sphere = Sphere{.radius = 0.5}, box = Box{{0.5, 0.4, 0.3}};
  Measure(bench, {"spheres", sphere, kSphereMax}, outcome);
  Measure(bench, {"boxes", box, kBoxMax}, outcome);
  Measure(bench, {"falling spheres", sphere, kSphereMax, true}, outcome);
  Measure(bench, {"falling boxes", box, kBoxMax, true}, outcome);
  return outcome;
}

}  // namespace genphys::bench

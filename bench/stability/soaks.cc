#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <span>
#include <string>

#include "contenders/clock.h"
#include "contenders/dice.h"
#include "trial.h"

namespace genphys::bench {
namespace {

Shape AnyShape(Dice& dice, double low, double high) {
  const auto size = [&] { return dice.LogBetween(low, high); };
  const double kind = dice.Next();
  if (kind < -0.5) return Sphere{size()};
  const double a = size(), b = size(), c = size();
  if (kind < 0) return Box{{a, b, c}};
  if (kind < 0.5) return Capsule{a, b};
  return Cylinder{a, b};
}

Quaternion AnyTurn(Dice& dice) { return Turn(std::numbers::pi * dice.Next(), dice.NextVector().normalized()); }

double ResidentMegabytes() {
  std::ifstream file("/proc/self/statm");
  double pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

// 200 bodies on a walled floor, fallen in from above.
Scene Playpen(Dice& dice) {
  constexpr size_t kBodies = 200;
  constexpr double kHalf = 5;
  Scene scene{.has_ground = true, .friction = 0.5, .restitution = 0.3, .may_sleep = true};
  for (size_t i = 0; i < kBodies; ++i) {
    const Vector3 place(0.8 * kHalf * dice.Next(), 0.8 * kHalf * dice.Next(), 1 + 0.1 * static_cast<double>(i));
    scene.Add(AnyShape(dice, 0.1, 0.3), 1, {place, AnyTurn(dice)});
  }
  for (int axis = 0; axis < 2; ++axis) {
    for (const double side : {-1.0, 1.0}) scene.AddStatic(Plane{side * Vector3::Unit(axis), -kHalf});
  }
  return scene;
}

// Puts them in another order.
double Quantile(std::span<double> values, double q) {
  const auto place = static_cast<ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<size_t>(place)];
}

// Somebody is kicked every second; who lies still may sleep.
std::vector<Quantity> Soak(const Lab& lab, uint32_t seed, int64_t steps) {
  constexpr int64_t kBetweenKicks = 60;
  constexpr int64_t kFirst = 10'000;
  constexpr size_t kKicked = 200;
  Dice dice(seed);
  const Scene scene = Playpen(dice);
  Run run = lab.Start(scene);
  const double start = run.Energy();
  double injected = 0, excess = 0, first_p99 = 0, memory = 0;
  // All of it from the start on, or it would be what memory grows by.
  std::vector<double> times(static_cast<size_t>(steps));
  size_t timed = 0;
  for (int64_t step = 1; step <= steps; ++step) {
    const double begin = ProcessorTime();
    run.StepTo(static_cast<double>(step) * lab.step_size());
    times[timed++] = ProcessorTime() - begin;
    if (step == kFirst) {
      first_p99 = Quantile(std::span(times).first(timed), 0.99);
      memory = ResidentMegabytes();
      timed = 0;
    }
    if (step % kBetweenKicks != 0) continue;
    const double before = run.Energy();
    excess = std::max(excess, (before - start - injected) / start);
    const auto who = static_cast<size_t>(dice.Between(0, kKicked - 1e-6));
    run.simulation().Kick(who, 5 * dice.NextVector() + Vector3(0, 0, 2));
    injected += run.Energy() - before;
  }
  double lost = 0;
  for (size_t i = 0; i < kKicked; ++i) {
    const Vector3 place = run[i].position;
    lost += place.allFinite() && place.z() > 0 && place.head<2>().cwiseAbs().maxCoeff() < 5 ? 0 : 1;
  }
  return {{"energy_excess", excess},
          {"lost", lost},
          {"memory_mb", std::max(ResidentMegabytes() - memory, 0.0)},
          {"slowdown", Quantile(std::span(times).first(timed), 0.99) / first_p99}};
}

Trial LongLife(const std::string& id, int64_t steps, bool is_long) {
  Trial trial{.id = id,
              .title = "200 bodies in a pen, one of them kicked every second, " + std::to_string(steps) + " steps",
              .limits = {{"energy_excess", 0}, {"lost", 0}, {"memory_mb", 1}, {"slowdown", 2}},
              .is_long = is_long};
  trial.run = [steps](const Lab& lab, uint32_t seed) { return Soak(lab, seed, steps); };
  return trial;
}

struct AnyWorld {
  Scene scene;
  double step_size = 0;
};

// Bodies of any shape and mass, some inside each other, some joined, some pushed.
AnyWorld MakeAnyWorld(uint32_t seed) {
  constexpr size_t kBodies = 12;
  constexpr double kSpeed = 5;
  Dice dice(seed);
  AnyWorld world{.scene = {.has_ground = true}};
  world.scene.friction = dice.Between(0, 1);
  world.scene.restitution = dice.Between(0, 1);
  for (size_t i = 0; i < kBodies; ++i) {
    const Vector3 place = 1.2 * dice.NextVector() + Vector3(0, 0, 2);
    const double mass = dice.LogBetween(1e-3, 1e3);
    world.scene.Add(AnyShape(dice, 0.05, 0.5), mass, {place, AnyTurn(dice)}, kSpeed / 2 * dice.NextVector(),
                    3 * dice.NextVector());
  }
  for (size_t i = 1; i < kBodies; ++i) {
    const double kind = dice.Next();
    const Vector3 anchor = world.scene.bodies[i].pose.position;
    if (kind > 0.6) world.scene.Join(BallJoint{}, i - 1, i, anchor);
    if (kind > 0.3 && kind <= 0.6) world.scene.Join(HingeJoint{}, i - 1, i, anchor, dice.NextVector().normalized());
  }
  world.step_size = dice.LogBetween(1e-4, 1.0 / 30);
  return world;
}

struct Played {
  std::vector<Motion> motions;
  double speed = 0;          // m/s, the highest
  double energy_excess = 0;  // over that at the start and the work of the pushes, of that at the start, at most
};

Played Play(const Lab& lab, const AnyWorld& world, uint32_t seed) {
  constexpr int kSteps = 300;
  Dice dice(seed + 1'000'000);
  Run run = lab.Start(world.scene, world.step_size);
  const size_t bodies = world.scene.bodies.size();
  std::vector<Vector3> pushes(bodies, Vector3::Zero());
  for (size_t i = 0; i < bodies; ++i) {
    if (dice.Next() > 0) continue;
    pushes[i] = 10 * *world.scene.bodies[i].rigid_body->inertia.mass * dice.NextVector();
    run.simulation().Hold(i, pushes[i], Vector3::Zero());
  }
  const double start = run.Energy();
  Played played{.motions = std::vector<Motion>(bodies)};
  run.StepTo(kSteps * world.step_size, [&] {
    double work = 0;
    for (size_t i = 0; i < bodies; ++i) {
      const Motion& now = played.motions[i] = run[i];
      work += pushes[i].dot(now.position - world.scene.bodies[i].pose.position);
      played.speed = std::max(played.speed, now.velocity.norm());
    }
    const double excess = (run.Energy() - work - start) / start;
    // What was no number once stays none.
    if (!std::isnan(played.energy_excess) && !(excess <= played.energy_excess)) played.energy_excess = excess;
  });
  return played;
}

bool IsSame(const std::vector<Motion>& a, const std::vector<Motion>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Motion& x, const Motion& y) {
    return x.position == y.position && x.orientation.coeffs() == y.orientation.coeffs() && x.velocity == y.velocity &&
           x.spin == y.spin;
  });
}

// How fast anybody comes to be is told, but is no measure: a link of some grams that hangs on tons may be cracked like
// a whip. Energy is one, for pushes that stay the same, contacts and joints have none to give.
Trial AnyWorlds(const std::string& id, uint32_t worlds, bool is_long) {
  // What joints hold may have a fifth more energy of its turning than it was given: steps do not resolve how what turns
  // by more than a radian in each of them goes on.
  constexpr double kExcessMax = 0.2;
  Trial trial{.id = id,
              .title = std::to_string(worlds) + " random worlds of 12 bodies, 300 steps, twice",
              .limits = {{"replay_differs", 0}, {"energy_excess", kExcessMax}},
              .seeds = worlds,
              .is_long = is_long};
  trial.run = [](const Lab& lab, uint32_t seed) -> std::vector<Quantity> {
    const AnyWorld world = MakeAnyWorld(seed);
    const Played first = Play(lab, world, seed), second = Play(lab, world, seed);
    return {{"replay_differs", IsSame(first.motions, second.motions) ? 0.0 : 1.0},
            {"energy_excess", first.energy_excess},
            {"speed", first.speed}};
  };
  return trial;
}

}  // namespace

void AddSoaks(std::vector<Trial>& trials) {
  trials.push_back(LongLife("S15", 20'000, false));
  trials.push_back(LongLife("S15.long", 1'000'000, true));
  trials.push_back(AnyWorlds("S16", 200, false));
  trials.push_back(AnyWorlds("S16.long", 10'000, true));
}

std::vector<Trial> Trials() {
  std::vector<Trial> trials;
  AddStacks(trials);
  AddLinks(trials);
  AddHits(trials);
  AddSpins(trials);
  AddSoaks(trials);
  // As their numbers say.
  std::ranges::stable_sort(trials, {}, [](const Trial& trial) { return std::stoi(trial.id.substr(1)); });
  return trials;
}

}  // namespace genphys::bench

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "contenders/dice.h"
#include "trial.h"

namespace genphys::bench {
namespace {

constexpr double kTime = 10;
constexpr double kDisturbance = 1e-6;  // m, of where a body starts, sideways
constexpr uint32_t kSeeds = 5;

Scene Floor() { return {.has_ground = true, .friction = 0.5}; }

Pose Disturbed(Dice& dice, const Vector3& place) {
  const double x = dice.Next(), y = dice.Next();
  return {.position = place + kDisturbance * Vector3(x, y, 0)};
}

Scene Stack(int count, uint32_t seed) {
  Scene scene = Floor();
  Dice dice(seed);
  for (int i = 0; i < count; ++i) scene.Add(Box{}, 1, Disturbed(dice, {0, 0, i + 0.5}));
  return scene;
}

// Faces that meet in up to eight corners, which lie as deep as each other.
Scene TurnedStack(int count, double side, uint32_t seed) {
  Scene scene = Floor();
  Dice dice(seed);
  for (int i = 0; i < count; ++i) {
    Pose pose = At(0, 0, (i + 0.5) * side);
    pose.orientation = Turn(std::numbers::pi * dice.Next(), Vector3::UnitZ());
    scene.Add(Box{Vector3::Constant(side / 2)}, 1, pose);
  }
  return scene;
}

// Undisturbed: far away a disturbance would be rounded.
Scene StackAt(double far, int count) {
  Scene scene = Floor();
  for (int i = 0; i < count; ++i) scene.Add(Box{}, 1, At(far, 0, i + 0.5));
  return scene;
}

// How far the farthest of the boxes with sides of `side` m is from where it should be, and how the topmost lies, all in
// sides, and how they move.
std::vector<Quantity> Standing(const Run& run, int count, double side = 1) {
  double deviation = 0, speed = 0, drift = 0;
  for (int i = 0; i < count; ++i) {
    const Motion motion = run[static_cast<size_t>(i)];
    const Vector3 off = motion.position / side - Vector3(0, 0, i + 0.5);
    deviation = std::max(deviation, off.norm());
    drift = std::max(drift, off.head<2>().norm());
    speed = std::max(speed, motion.velocity.norm());
  }
  const double sag = count - 0.5 - run[static_cast<size_t>(count - 1)].position.z() / side;
  return {{"deviation", deviation}, {"sag", std::abs(sag) / count}, {"drift", drift}, {"speed", speed}};
}

Trial StackOf(int count) {
  Trial trial{.id = "S1." + std::to_string(count),
              .title = "stack of " + std::to_string(count) + " unit cubes for 10 s",
              .limits = {{"deviation", 0.25}, {"sag", 0.01}, {"drift", 0.1}, {"speed", 0.02}},
              .seeds = kSeeds};
  trial.run = [count](const Lab& lab, uint32_t seed) {
    Run run = lab.Start(Stack(count, seed));
    run.StepTo(kTime);
    return Standing(run, count);
  };
  return trial;
}

Trial TurnedStackOf(int count) {
  constexpr double kSide = 0.1;  // m
  Trial trial{.id = "S1turned." + std::to_string(count),
              .title = "stack of " + std::to_string(count) + " cubes of 10 cm, each turned, for 10 s; lengths in sides",
              .limits = {{"deviation", 0.25}, {"sag", 0.01}, {"drift", 0.1}, {"speed", 0.02}},
              .seeds = kSeeds};
  trial.run = [count](const Lab& lab, uint32_t seed) {
    Run run = lab.Start(TurnedStack(count, kSide, seed));
    run.StepTo(kTime);
    return Standing(run, count, kSide);
  };
  return trial;
}

Trial HeavyOnLight(int exponent) {
  const std::string ratio = "1e" + std::to_string(exponent);
  Trial trial{.id = "S2." + ratio,
              .title = "cube of " + ratio + " kg on one of 1 kg for 5 s",
              .limits = {{"penetration", 0.01}, {"drift", 0.1}},
              .seeds = kSeeds};
  trial.run = [exponent](const Lab& lab, uint32_t seed) -> std::vector<Quantity> {
    Scene scene = Floor();
    Dice dice(seed);
    scene.Add(Box{}, 1, Disturbed(dice, {0, 0, 0.5}));
    scene.Add(Box{}, std::pow(10, exponent), Disturbed(dice, {0, 0, 1.5}));
    Run run = lab.Start(scene);
    double penetration = 0;
    run.StepTo(5, [&] { penetration = std::max(penetration, 1.5 - run[1].position.z()); });
    return {{"penetration", penetration}, {"drift", run[1].position.head<2>().norm()}};
  };
  return trial;
}

Trial FarAway(const std::string& distance, double far) {
  constexpr int kCount = 5;
  Trial trial{.id = "S8." + distance,
              .title = "stack of 5 at " + distance + " m, against the same at the origin",
              .limits = {{"difference", 1e-6}}};
  trial.run = [far](const Lab& lab, uint32_t) -> std::vector<Quantity> {
    Run here = lab.Start(StackAt(0, kCount));
    Run there = lab.Start(StackAt(far, kCount));
    here.StepTo(kTime);
    there.StepTo(kTime);
    double difference = 0;
    for (size_t i = 0; i < kCount; ++i) {
      difference = std::max(difference, (there[i].position - here[i].position - Vector3(far, 0, 0)).norm());
    }
    return {{"difference", difference}};
  };
  return trial;
}

Trial MirroredPile() {
  constexpr int kBase = 8;
  constexpr double kSpacing = 1.05;
  Trial trial{
      .id = "S14", .title = "pyramid of 36 boxes that is its own mirror image, 5 s", .limits = {{"asymmetry", 1e-9}}};
  trial.run = [](const Lab& lab, uint32_t) -> std::vector<Quantity> {
    Scene scene = Floor();
    for (int row = 0; row < kBase; ++row) {
      for (int i = 0; i < kBase - row; ++i) {
        scene.Add(Box{}, 1, At(kSpacing * (i - (kBase - row - 1) / 2.0), 0, row + 0.51));
      }
    }
    Run run = lab.Start(scene);
    run.StepTo(5);
    double asymmetry = 0;
    size_t first = 0;
    for (int row = 0; row < kBase; ++row) {
      const auto count = static_cast<size_t>(kBase - row);
      for (size_t i = 0; i < count; ++i) {
        const Vector3 a = run[first + i].position;
        const Vector3 b = run[first + count - 1 - i].position;
        asymmetry = std::max(asymmetry, (a - Vector3(-b.x(), b.y(), b.z())).norm());
      }
      first += count;
    }
    return {{"asymmetry", asymmetry}};
  };
  return trial;
}

}  // namespace

void AddStacks(std::vector<Trial>& trials) {
  for (const int count : {5, 10, 15, 20, 30, 40}) trials.push_back(StackOf(count));
  for (const int count : {5, 10, 15}) trials.push_back(TurnedStackOf(count));
  for (const int exponent : {2, 4, 6}) trials.push_back(HeavyOnLight(exponent));
  trials.push_back(FarAway("1e3", 1e3));
  trials.push_back(FarAway("1e6", 1e6));
  trials.push_back(MirroredPile());
}

}  // namespace genphys::bench

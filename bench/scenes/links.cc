// What hangs on joints without motors.
#include <numbers>

#include "case.h"
#include "contenders/dice.h"

namespace genphys::bench {
namespace {

Scene Bridge() {
  constexpr int kPlanks = 30;
  constexpr double kLength = 0.5, kHeight = 6;
  Scene scene{.has_ground = true, .friction = 0.5};
  std::optional<size_t> before;
  const auto hang = [&](std::optional<size_t> a, size_t b, double x) {
    for (const double y : {-0.9, 0.9}) scene.Join(BallJoint{}, a, b, {x, y, kHeight});
  };
  for (int i = 0; i < kPlanks; ++i) {
    const size_t plank = scene.Add(Box{{0.23, 1, 0.05}}, 5, At(kLength * (i + 0.5), 0, kHeight));
    hang(before, plank, kLength * i);
    before = plank;
  }
  hang(std::nullopt, *before, kLength * kPlanks);
  for (int i = 0; i < kPlanks; ++i) {
    const double x = kLength * kPlanks * (0.1 + 0.8 * (i + 0.5) / kPlanks);
    scene.Add(Box{{0.2, 0.2, 0.2}}, 1, At(x, i % 2 == 0 ? -0.4 : 0.4, kHeight + 0.3));
  }
  return scene;
}

// From 30 degrees.
Scene Chain() {
  constexpr int kLinks = 40;
  constexpr double kLink = 0.1, kLoad = 20;
  Scene scene;
  const Quaternion turn = Turn(-std::numbers::pi / 6, Vector3::UnitY());
  const Vector3 along = turn * -Vector3::UnitZ();
  std::optional<size_t> above;
  for (int i = 0; i < kLinks; ++i) {
    const size_t link = scene.Add(Capsule{0.02, kLink / 2 - 0.02}, 0.1, {along * kLink * (i + 0.5), turn});
    scene.Join(BallJoint{}, above, link, along * kLink * i);
    above = link;
  }
  const size_t load = scene.Add(Sphere{0.15}, kLoad, {along * (kLink * kLinks + 0.15), turn});
  scene.Join(BallJoint{}, above, load, along * kLink * kLinks);
  return scene;
}

Scene Doors() {
  constexpr int kCount = 100, kRow = 10;
  constexpr double kOpen = 1.5;
  Scene scene;
  Dice dice(kSeed);
  for (int i = 0; i < kCount; ++i) {
    const Vector3 post(3 * (i % kRow), 3 * (i / kRow), 1);
    const double spin = dice.Between(1, 3);
    const Vector3 to_middle(0.45, 0, 0);
    const size_t door = scene.Add(Box{{0.45, 0.02, 1}}, 20, {.position = post + to_middle},
                                  Vector3(0, 0, spin).cross(to_middle), Vector3(0, 0, spin));
    scene.Join(HingeJoint{{.limits = {.lower = -kOpen, .upper = kOpen}, .motor = {}, .spring = {}}}, std::nullopt, door,
               post);
  }
  return scene;
}

}  // namespace

void AddLinks(std::vector<Case>& cases) {
  cases.push_back({.id = "bridge",
                   .title = "30 boxes fall onto a bridge of 30 planks that hangs on two ropes of ball joints",
                   .make = Bridge,
                   .phases = {{"falling", 0, 1.5}, {"lying", 4, 1}}});
  cases.push_back({.id = "chain",
                   .title = "a chain of 40 links with the fivefold mass of all at its end",
                   .make = Chain,
                   .phases = {{"swinging", 0, 3}},
                   .lowest = -10});
  cases.push_back(
      {.id = "doors", .title = "100 doors swing to their limits", .make = Doors, .phases = {{"swinging", 0, 2}}});
}

}  // namespace genphys::bench

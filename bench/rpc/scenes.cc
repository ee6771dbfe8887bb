#include "scenes.h"

#include <cmath>
#include <random>

namespace genphys::bench {
namespace {

constexpr double kStepsPerSecond = 60;

EntityDesc MakeBox(const Vector3& position, const Vector3& half_extents) {
  RigidBody body;
  body.geometries.push_back({.shape = Box{half_extents}});
  body.inertia.mass = 1;
  return {.pose = {.position = position}, .rigid_body = body};
}

// Integers come out of this generator alike everywhere; the distributions of the standard library do not.
class Jitter {
 public:
  /// From -1 to 1.
  double Next() { return 2.0 * static_cast<double>(generator_()) / static_cast<double>(std::mt19937::max()) - 1; }

 private:
  std::mt19937 generator_{1};
};

Scene Sleepers(const std::string& engine) {
  constexpr uint32_t kRow = 40;
  constexpr double kSpacing = 2;
  Scene scene{.name = "sleepers", .world = {.engine = engine}, .steps_before = 120, .ends_up_asleep = true};
  scene.world.ground_plane = true;
  for (uint32_t i = 0; i < kSceneEntities; ++i) {
    scene.entities.push_back(MakeBox({kSpacing * (i % kRow), kSpacing * (i / kRow), 0.5}, {0.5, 0.5, 0.5}));
  }
  return scene;
}

Scene Flyers(const std::string& engine) {
  constexpr uint32_t kRow = 10;
  constexpr double kSpacing = 3;
  constexpr double kSpread = 0.1;  // 1/s: each flies away from the middle, so that the gaps only grow
  Scene scene{.name = "flyers", .world = {.engine = engine}, .steps_before = 10};
  scene.world.ground_plane = false;
  scene.world.default_auto_disable.enabled = false;
  Jitter jitter;
  for (uint32_t i = 0; i < kSceneEntities; ++i) {
    const Vector3 place(i % kRow, i / kRow % kRow, i / kRow / kRow);
    const Vector3 from_middle = kSpacing * (place - Vector3::Constant((kRow - 1) / 2.0));
    EntityDesc flyer = MakeBox(from_middle, {0.5, 0.4, 0.3});
    flyer.rigid_body->linear_velocity = kSpread * from_middle;
    for (double& spin : flyer.rigid_body->angular_velocity) spin = jitter.Next();
    scene.entities.push_back(flyer);
  }
  return scene;
}

}  // namespace

Scene PileOf(const std::string& engine, uint32_t boxes) {
  // Ten layers, whatever the number.
  const auto row = static_cast<uint32_t>(std::lround(std::sqrt(boxes / 10.0)));
  constexpr double kSpacing = 1.3;
  constexpr double kRise = 1.1;
  constexpr double kAside = 0.3;  // m: boxes land on the edges of others, so that it is a pile and no columns
  constexpr double kTurn = 0.3;   // rad
  Scene scene{.name = "pile", .world = {.engine = engine}};
  // It falls, tumbles and has come to rest after this; it would sleep then.
  scene.steps_before = static_cast<uint32_t>(4 * kStepsPerSecond);
  scene.world.ground_plane = true;
  scene.world.default_auto_disable.enabled = false;
  Jitter jitter;
  for (uint32_t i = 0; i < boxes; ++i) {
    const uint32_t layer = i / row / row;
    const double aside = layer % 2 == 0 ? -kAside : kAside;
    const Vector3 position(kSpacing * (i % row) + aside, kSpacing * (i / row % row) + aside, 0.6 + kRise * layer);
    EntityDesc box = MakeBox(position, {0.5, 0.5, 0.5});
    const double half_turn = kTurn * jitter.Next() / 2;
    // About the vertical, by too little for the corners of neighbours to meet before they fall.
    box.pose.orientation = Quaternion(std::cos(half_turn), 0, 0, std::sin(half_turn));
    scene.entities.push_back(box);
  }
  return scene;
}

std::vector<Scene> Scenes(const std::string& engine) {
  return {Sleepers(engine), Flyers(engine), PileOf(engine, kSceneEntities)};
}

}  // namespace genphys::bench

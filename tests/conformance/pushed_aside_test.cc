// What is pushed out of its middle, by less than friction holds and less than tips it, stays where it lies.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "conformance/engine_test.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(PushedAside);

constexpr double kGravity = 9.81;
constexpr double kCreepMax = 1e-6;  // m/s, which is promised

/// A body as it lies before anything pushes it, and the push.
struct Lying {
  EntityDesc desc;
  Vector3 force = Vector3::Zero();
  double height = 0;  // m, over the floor, at which it is pushed
};

std::unique_ptr<World> OnFloor(const std::string& engine, int steps) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = 1.0 / steps}};
  desc.default_auto_disable.enabled = false;
  // Frictions below are those of the pairs.
  desc.default_material = {.friction = 3, .friction_mixing = Mixing::kMinimum};
  return MakeWorld(desc);
}

Vector3 Across(double heading) { return {std::cos(heading), std::sin(heading), 0}; }

/// Pushed along x with `part` of what makes it slip or tip.
Lying LyingBox(Random& random, double part, const Vector3& place) {
  const double a = random.Uniform(0.05, 0.35), b = random.Uniform(0.05, 0.35), h = random.Uniform(0.05, 0.55);
  const double friction = random.Uniform(0.2, 1.7), heading = random.Uniform(0, 2 * std::numbers::pi);
  const double mass = random.LogUniform(0.1, 10), height = 2 * h * random.Uniform(0.1, 1);
  const double edge = std::min(a / std::abs(std::cos(heading)), b / std::abs(std::sin(heading)));
  EntityDesc box = Body(Box{{a, b, h}}, place + Vector3(0, 0, h), mass);
  box.rigid_body->geometries[0].material = {.friction = friction, .friction_mixing = Mixing::kMinimum};
  box.pose.orientation = Quaternion(Eigen::AngleAxisd(heading, Vector3::UnitZ()));
  return {box, {part * std::min(friction, edge / height) * mass * kGravity, 0, 0}, height};
}

/// On four legs, pushed any way.
Lying LyingTable(Random& random, double part, const Vector3& place) {
  const double x = random.Uniform(0.2, 0.5), y = random.Uniform(0.2, 0.5), h = random.Uniform(0.1, 0.4);
  const double friction = random.Uniform(0.2, 1.2), height = 2 * h * random.Uniform(0.1, 0.9), leg = 0.03;
  EntityDesc table = Body(Box{{x, y, leg}}, place + Vector3(0, 0, h), 2);
  std::vector<Geometry>& parts = table.rigid_body->geometries;
  parts[0].material = {.friction = friction, .friction_mixing = Mixing::kMinimum};
  parts[0].pose_in_entity.position.z() = h - leg;
  for (const double side_x : {-1.0, 1.0}) {
    for (const double side_y : {-1.0, 1.0}) {
      Geometry added = parts[0];
      added.shape = Box{{leg, leg, h}};
      added.pose_in_entity.position = {side_x * (x - leg), side_y * (y - leg), 0};
      parts.push_back(added);
    }
  }
  table.pose.orientation = Quaternion(Eigen::AngleAxisd(random.Uniform(0, 2 * std::numbers::pi), Vector3::UnitZ()));
  const double most = std::min(friction, 0.9 * (std::min(x, y) - 2 * leg) / height);
  return {table, part * most * 2 * kGravity * Across(random.Uniform(0, 2 * std::numbers::pi)), height};
}

/// m: how far the one that goes farthest goes in the second second of its push, each of so many steps.
double MostCreptBy(World& world, int second, const std::vector<Lying>& all) {
  std::vector<EntityId> ids;
  for (const Lying& lying : all) ids.push_back(Add(world, lying.desc));
  Steps(world, second / 4);
  for (size_t i = 0; i < all.size(); ++i) {
    const Vector3 place = all[i].desc.pose.position;
    Do(world, ApplyForce{.id = ids[i],
                         .force = all[i].force,
                         .point = Vector3(place.x(), place.y(), all[i].height),
                         .steps = 3u * static_cast<uint32_t>(second)});
  }
  Steps(world, second);
  std::vector<Vector3> before;
  for (const EntityId id : ids) before.push_back(PositionOf(world, id));
  Steps(world, second);
  double most = 0;
  for (size_t i = 0; i < ids.size(); ++i) most = std::max(most, (PositionOf(world, ids[i]) - before[i]).norm());
  return most;
}

TEST_P(PushedAside, ABoxStaysHoweverLittleOrMuchPushesIt) {
  Proves({Claim::kStaticFriction, Claim::kBox});
  for (const int steps : {60, 240}) {
    Random random(7);
    for (int i = 0; i < 40; ++i) {
      SCOPED_TRACE(i);
      const double part = i % 2 == 0 ? random.Uniform(0.3, 0.98) : random.LogUniform(0.01, 0.3);
      const auto world = OnFloor(GetParam(), steps);
      EXPECT_LE(MostCreptBy(*world, steps, {LyingBox(random, part, Vector3::Zero())}), kCreepMax);
    }
  }
}

TEST_P(PushedAside, ATableOfFourLegsStays) {
  Proves({Claim::kStaticFriction, Claim::kCompound});
  Random random(3);
  for (int i = 0; i < 10; ++i) {
    SCOPED_TRACE(i);
    const auto world = OnFloor(GetParam(), 60);
    EXPECT_LE(MostCreptBy(*world, 60, {LyingTable(random, random.Uniform(0.3, 0.95), Vector3::Zero())}), kCreepMax);
  }
}

// Sweeps go through all of them together.
TEST_P(PushedAside, ManyBoxesOfOneWorldStay) {
  Proves({Claim::kStaticFriction, Claim::kBox});
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = OnFloor(GetParam(), 60);
    std::vector<Lying> all;
    for (int i = 0; i < 64; ++i) {
      all.push_back(LyingBox(random, random.Uniform(0.3, 0.9), {3.0 * (i % 8), 3.0 * (i / 8), 0}));
    }
    EXPECT_LE(MostCreptBy(*world, 60, all), kCreepMax);
  }
}

}  // namespace
}  // namespace genphys::testing

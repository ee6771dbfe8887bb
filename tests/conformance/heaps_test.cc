// What lies on each other stands, and slides as one where friction between it holds more than that of the ground.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "conformance/engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Heaps, Claim::kContacts, Claim::kKineticFriction, Claim::kPlane, Claim::kBox);

constexpr double kGravity = 9.81, kFriction = 0.3;
// Of a material on itself, so that with the floor it comes to kFriction.
constexpr double kRough = 0.9;

std::unique_ptr<World> FloorOf(const std::string& engine, int rate, double friction, const Vector3& gravity) {
  WorldDesc desc{.engine = engine, .gravity = gravity, .stepper = {.step_size = 1.0 / rate}};
  desc.default_material.friction = friction;
  desc.default_auto_disable.enabled = false;
  return MakeWorld(desc);
}

// Boxes of these masses, the first one lowest.
std::vector<EntityId> AddTower(World& world, const Vector3& half, const std::vector<double>& masses, double friction) {
  std::vector<EntityId> tower;
  for (const double mass : masses) {
    const double height = half.z() * (2 * static_cast<double>(tower.size()) + 1);
    EntityDesc box = Body(Box{half}, {0, 0, height}, mass);
    box.rigid_body->geometries.front().material.friction = friction;
    tower.push_back(Add(world, box));
  }
  return tower;
}

// By the criterion of bench/stability, S1.
TEST_P(Heaps, OfFifteenBoxesStandHoweverFlatTheseAre) {
  constexpr int kCount = 15, kRate = 60, kSeconds = 10;
  constexpr double kDeviation = 0.25;  // m
  for (const Vector3& half : {Vector3(0.5, 0.5, 0.5), Vector3(0.5, 0.5, 0.25), Vector3(0.3, 0.3, 0.15)}) {
    const auto world = FloorOf(GetParam(), kRate, 0.5, {0, 0, -kGravity});
    const auto tower = AddTower(*world, half, std::vector<double>(kCount, 1.0), 0.5);
    Steps(*world, kRate * kSeconds);
    for (int i = 0; i < kCount; ++i) {
      const Vector3 place(0, 0, half.z() * (2 * i + 1));
      EXPECT_LT((PositionOf(*world, tower[static_cast<size_t>(i)]) - place).norm(), kDeviation) << half.z() << " " << i;
    }
  }
}

TEST_P(Heaps, StayOnASlopeOrSlideDownItAsOneWould) {
  constexpr double kSeconds = 1;
  const std::vector<std::vector<double>> towers = {{1, 5}, {1, 1, 1}, {1, 1.5, 2, 0.5, 1}};
  for (const int rate : {60, 240}) {
    for (const double steep : {0.95, 1.05, 1.15, 1.4}) {
      for (const auto& masses : towers) {
        for (const double heading : {0.0, 0.7}) {
          SCOPED_TRACE(::testing::Message() << rate << " " << steep << " " << masses.size() << " " << heading);
          const double angle = std::atan(steep * kFriction);
          const Vector3 down(std::cos(heading), std::sin(heading), 0);
          const Vector3 gravity = kGravity * (std::sin(angle) * down - std::cos(angle) * Vector3::UnitZ());
          const auto world = FloorOf(GetParam(), rate, kFriction * kFriction / kRough, gravity);
          const auto tower = AddTower(*world, {0.3, 0.3, 0.03}, masses, kRough);
          Steps(*world, static_cast<int>(kSeconds * rate));
          const double pull = std::max(0.0, std::sin(angle) - kFriction * std::cos(angle)) * kGravity;
          // Of what it is pulled by within a substep, while weight comes to rest on the lower ones.
          const double tolerance = kGravity * std::sin(angle) * SubstepOf(*world) * SubstepOf(*world);
          for (size_t i = 0; i < tower.size(); ++i) {
            const Vector3 place(0, 0, 0.06 * static_cast<double>(i) + 0.03);
            const Vector3 way = PositionOf(*world, tower[i]) - place;
            EXPECT_NEAR((way - pull * kSeconds * kSeconds / 2 * down).norm(), 0, tolerance);
          }
        }
      }
    }
  }
}

TEST_P(Heaps, ArePulledAlongByTheTopmostFromTheFirstStepOn) {
  constexpr double kSeconds = 0.5, kPull = 1.15;
  for (const int rate : {30, 60, 240}) {
    for (const double heading : {0.0, 0.7}) {
      const auto world = FloorOf(GetParam(), rate, kFriction * kFriction / kRough, {0, 0, -kGravity});
      const auto tower = AddTower(*world, {0.3, 0.3, 0.05}, {1, 1.5}, kRough);
      const Vector3 along(std::cos(heading), std::sin(heading), 0);
      const double force = kPull * kFriction * 2.5 * kGravity;
      Do(*world, ApplyForce{.id = tower.back(), .force = force * along, .steps = static_cast<uint32_t>(rate)});
      Steps(*world, static_cast<int>(kSeconds * rate));
      const double acceleration = (kPull - 1) * kFriction * kGravity, way = acceleration * kSeconds * kSeconds / 2;
      // In a first solve nothing tells where the lower one will slip: it may begin half a substep late.
      const double tolerance = 1.01 * acceleration * SubstepOf(*world) / 2 * kSeconds;
      for (size_t i = 0; i < tower.size(); ++i) {
        const Vector3 place(0, 0, 0.1 * static_cast<double>(i) + 0.05);
        EXPECT_NEAR((PositionOf(*world, tower[i]) - place - way * along).norm(), 0, tolerance) << rate << " " << i;
      }
    }
  }
}

}  // namespace
}  // namespace genphys::testing

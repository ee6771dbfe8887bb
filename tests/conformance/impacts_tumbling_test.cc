// What turns while it hits may hit again within a step, and be apart once more at its end.
#include <algorithm>
#include <cmath>

#include "conformance/engine_test.h"
#include "support/energy.h"
#include "support/random.h"
#include "support/tolerances.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(ImpactsOfTumbling, Claim::kContacts, Claim::kRestitution);

constexpr int kPairs = 2000;
constexpr int kSteps = 72;        // in which the slowest meet and part again
const Vector3 kMiddle(0, 0, 10);  // far above the floor

EntityDesc Thrown(Random& random, const Vector3& from, double speed) {
  EntityDesc body = Body(Box{{random.Uniform(0.1, 0.5), random.Uniform(0.1, 0.5), random.Uniform(0.1, 0.5)}},
                         kMiddle + from, random.LogUniform(0.3, 3));
  body.pose.orientation = random.Turn();
  body.rigid_body->linear_velocity = speed * (0.25 * random.Direction() - from).normalized();
  body.rigid_body->angular_velocity = random.Uniform(0, 3) * random.Direction();
  body.rigid_body->geometries[0].material.friction = 0;
  body.rigid_body->geometries[0].material.restitution = 1;
  return body;
}

// Of the energy of what turns by `turn` rad in each substep, relative: of the exponential of a turn the first four
// powers are right.
double TurnError(double turn, int substeps) { return substeps * std::pow(turn, 5) / 120; }

TEST_P(ImpactsOfTumbling, KeepTheEnergyOfElasticBoxes) {
  Random random(3);
  int hits = 0;
  for (int i = 0; i < kPairs; ++i) {
    WorldDesc desc{.engine = GetParam(), .gravity = Vector3::Zero()};
    desc.default_auto_disable.enabled = false;
    const auto world = testing::MakeWorld(desc);
    const Vector3 side = random.Direction();
    const EntityId a = Add(*world, Thrown(random, random.Uniform(1, 1.5) * side, random.Uniform(1, 5)));
    const EntityId b = Add(*world, Thrown(random, -random.Uniform(1, 1.5) * side, random.Uniform(1, 5)));
    const double before = KineticEnergyOf(*world);
    const Vector3 at_first = VelocityOf(*world, a);
    const double substep = SubstepOf(*world);
    double turn = 0;  // rad, in a substep, the most
    for (int step = 0; step < kSteps; ++step) {
      Steps(*world, 1);
      for (const EntityId id : {a, b}) turn = std::max(turn, substep * SpinOf(*world, id).norm());
    }
    hits += VelocityOf(*world, a) != at_first;
    const int substeps = static_cast<int>(std::lround(kSteps / (60 * substep)));
    EXPECT_NEAR(KineticEnergyOf(*world) / before, 1, 2 * TurnError(turn, substeps) + kRounded)
        << "pair " << i << " turns by " << turn;
  }
  EXPECT_GT(hits, kPairs / 2);
}

// A chip of so many metres that comes down at `speed` m/s askew, to the floor in the first step.
EntityDesc Chip(Random& random, double half, double speed, double step) {
  EntityDesc chip = Body(Box{{half, 0.6 * half, 0.3 * half}}, Vector3::Zero(), 1920 * half * half * half);
  Vector3 way = random.Direction();
  way.z() = -std::abs(way.z());
  chip.pose = {Vector3(0, 0, 2 * half) - 0.7 * step * speed * way, random.Turn()};
  chip.rigid_body->linear_velocity = speed * way;
  return chip;
}

TEST_P(ImpactsOfTumbling, TakeOutWhomTheyTurnTooFastAndNobodyElse) {
  Proves({Claim::kBounds, Claim::kFaultEvents});
  struct Shot {
    double half, speed, step;
  };
  size_t faults = 0;
  for (const Shot& shot : {Shot{1e-3, 300, 1.0 / 60}, {5e-4, 10, 0.25}, {1e-2, 1000, 0.25}}) {
    const auto world_of = [&] {
      auto world = testing::MakeWorld(WorldDesc{.engine = GetParam(), .stepper = {.step_size = shot.step}});
      EntityDesc crate = Crate({0, 50, 0.5});
      crate.rigid_body->linear_velocity = {0, 4, 0};
      return std::pair(std::move(world), crate);
    };
    auto [alone, crate] = world_of();
    const EntityId left_alone = Add(*alone, crate);
    Steps(*alone, 3);
    Random random(7);
    for (int i = 0; i < 40; ++i) {
      auto [world, same] = world_of();
      const EntityId other = Add(*world, same), chip = Add(*world, Chip(random, shot.half, shot.speed, shot.step));
      for (int k = 0; k < 3; ++k) ASSERT_TRUE(world->Step().ok()) << shot.half << " m at " << shot.speed << ", " << i;
      for (const EntityFaulted& fault : Of<EntityFaulted>(world->TakeEvents())) {
        EXPECT_EQ(fault.id, chip);
        ++faults;
      }
      EXPECT_LE(SpinOf(*world, chip).norm(), 3e4);
      EXPECT_EQ(PositionOf(*world, other), PositionOf(*alone, left_alone)) << "as if the chip were not there";
    }
  }
  EXPECT_GT(faults, 30u);
}

// Three moments that differ by a tenth and more, so that it turns over many times in each step.
TEST_P(ImpactsOfTumbling, GiveNoEnergyToWhatTurnsByHundredsOfRadiansInAStep) {
  Random random(5);
  int hits = 0;
  for (int i = 0; i < 40; ++i) {
    WorldDesc desc{.engine = GetParam(), .gravity = Vector3::Zero(), .stepper = {.step_size = 0.25}};
    desc.default_auto_disable.enabled = false;
    const auto world = testing::MakeWorld(desc);
    EntityDesc plate = Body(Box{{0.5, 0.35, 0.1}}, {0, 0, 3});
    plate.pose.orientation = random.Turn();
    plate.rigid_body->linear_velocity = {0, 0, -15};
    plate.rigid_body->angular_velocity = random.LogUniform(500, 4000) * random.Direction();
    plate.rigid_body->geometries[0].material.friction = 0;
    plate.rigid_body->geometries[0].material.restitution = 1;
    Add(*world, plate);
    const double before = KineticEnergyOf(*world);
    for (int k = 0; k < 2; ++k) ASSERT_TRUE(world->Step().ok());
    const std::vector<Event> events = world->TakeEvents();
    if (!Of<EntityFaulted>(events).empty()) continue;
    hits += !Of<ContactBegan>(events).empty();
    EXPECT_LE(KineticEnergyOf(*world) / before, 1 + 1e-3) << i;
  }
  EXPECT_GT(hits, 20);
}

// How deep the lowest corner of a box is in the floor, m.
double SunkBy(const World& world, EntityId id, const Vector3& half) {
  const Pose pose = world.state().pose(EntityRow{id.index()});
  return half.dot((pose.orientation.toRotationMatrix().transpose() * Vector3::UnitZ()).cwiseAbs()) - pose.position.z();
}

// The deepest that any of many boxes gets that come down askew, roll over each other and come to rest, m.
double DeepestOfThrown(const std::string& engine, uint32_t seed) {
  constexpr int kRow = 10, kFallSteps = 240;
  constexpr double kSpacing = 3;
  Random random(seed);
  const auto world = testing::MakeWorld(engine);
  std::vector<std::pair<EntityId, Vector3>> boxes;
  for (int i = 0; i < kRow * kRow; ++i) {
    const Vector3 half(random.Uniform(0.05, 0.4), random.Uniform(0.05, 0.4), random.Uniform(0.05, 0.4));
    const Vector3 place(kSpacing * (i % kRow), kSpacing * (i / kRow), random.Uniform(2, 4));
    EntityDesc box = Body(Box{half}, place, 4000 * half.prod());
    box.pose.orientation = random.Turn();
    box.rigid_body->linear_velocity = random.Uniform(2, 4) * random.Direction();
    box.rigid_body->angular_velocity = random.Uniform(4, 10) * random.Direction();
    box.rigid_body->geometries[0].material = {.friction = 0.5, .restitution = 0};
    boxes.emplace_back(Add(*world, box), half);
  }
  double deepest = 0;
  for (int step = 0; step < kFallSteps; ++step) {
    Steps(*world, 1);
    for (const auto& [id, half] : boxes) deepest = std::max(deepest, SunkBy(*world, id, half));
  }
  return deepest;
}

TEST_P(ImpactsOfTumbling, LetNobodySinkIntoTheFloor) {
  for (const uint32_t seed : {3, 4, 7, 25}) {
    EXPECT_LE(DeepestOfThrown(GetParam(), seed), 4e-3) << "seed " << seed;
  }
}

}  // namespace
}  // namespace genphys::testing

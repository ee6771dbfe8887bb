// Bodies that nothing can meet in a step are moved without the engine, and are met all the same when something comes.
#include <cmath>
#include <numbers>
#include <vector>

#include "conformance/engine_test.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Flight, Claim::kDamping);

constexpr double kStep = 1.0 / 60;
// Closed forms, step by step, of numbers up to fifty.
constexpr double kRounding = 50 * kRounded;

std::unique_ptr<World> MakeSpace(const std::string& engine, const Vector3& gravity) {
  auto world = MakeWorld(WorldDesc{.engine = engine, .gravity = gravity, .ground_plane = false});
  world->set_record_stats(true);
  return world;
}

TEST_P(Flight, WithDampingIsExactAtAnyStepSize) {
  constexpr double kDamping = 2.5, kGravity = 9.81;
  const Vector3 start(3, 0, 20);
  for (const double step : {kStep, 0.1}) {
    const auto world = MakeSpace(GetParam(), {0, 0, -kGravity});
    EntityDesc ball = Ball(Vector3::Zero());
    ball.rigid_body->linear_velocity = start;
    ball.rigid_body->linear_damping = kDamping;
    const EntityId id = Add(*world, ball);
    const int steps = static_cast<int>(std::lround(2 / step));
    for (int i = 0; i < steps; ++i) ASSERT_TRUE(world->Step(step).ok());

    EXPECT_EQ(world->stats().entities_in_flight, 1u);
    EXPECT_EQ(world->stats().entities_in_engine, 0u);
    // dv/dt = g - c v from rest at the origin with velocity v0.
    const double t = steps * step, decayed = -std::expm1(-kDamping * t);
    const Vector3 limit(0, 0, -kGravity / kDamping);
    const Vector3 place = limit * t + (start - limit) * decayed / kDamping;
    EXPECT_LT((PositionOf(*world, id) - place).norm(), kRounding) << step;
    EXPECT_LT((VelocityOf(*world, id) - (limit + (start - limit) * (1 - decayed))).norm(), kRounding) << step;
  }
}

// Each part of a body is taken to be anywhere in its region, so that two bodies whose regions meet make pairs of all of
// their parts.
TEST_P(Flight, OfManyBodiesOfManyPartsIsNotTakenForACrowd) {
  const auto world = MakeSpace(GetParam(), {0, 0, -9.81});
  constexpr int kParts = 16, kRow = 22;
  std::vector<Command> commands;
  for (int i = 0; i < kRow * kRow * kRow; ++i) {
    EntityDesc ring = Ball({3.0 * (i % kRow), 3.0 * (i / kRow % kRow), 3.0 * (i / kRow / kRow)}, 0.05);
    const Geometry part = ring.rigid_body->geometries.front();
    ring.rigid_body->geometries.clear();
    for (int k = 0; k < kParts; ++k) {
      const double angle = 2 * std::numbers::pi * k / kParts;
      Geometry placed = part;
      placed.pose_in_entity.position = {0.3 * std::cos(angle), 0.3 * std::sin(angle), 0};
      ring.rigid_body->geometries.push_back(placed);
    }
    commands.push_back(CreateEntity{ring});
  }
  ASSERT_TRUE(world->Apply(commands).ok());
  for (int i = 0; i < 3; ++i) {
    Steps(*world, 1);
    EXPECT_EQ(world->stats().entities_in_flight, commands.size());
  }
}

// Its farthest points are corners, and not where a ball around each part ends.
TEST_P(Flight, OfWhatHasPartsNeedsNoMoreRoomThanItTakesToTurn) {
  const auto world = MakeSpace(GetParam(), Vector3::Zero());
  for (const double x : {0.0, 1.1}) {
    EntityDesc cube = Body(Box{{0.3, 0.3, 0.15}}, {x, 0, 0});
    Geometry half = cube.rigid_body->geometries.front();
    half.pose_in_entity.position = {0, 0, 0.15};
    cube.rigid_body->geometries.front().pose_in_entity.position = {0, 0, -0.15};
    cube.rigid_body->geometries.push_back(half);
    Add(*world, cube);
  }
  Steps(*world, 1);
  EXPECT_EQ(world->stats().entities_in_flight, 2u);
}

// In a step they go past many places where somebody else is in some other step, and hardly ever meet.
TEST_P(Flight, OfFewInMuchRoomIsNoCrowdHoweverFastTheyAre) {
  constexpr int kRow = 10;
  constexpr double kApart = 10;
  for (const double speed : {20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 3000.0}) {
    SCOPED_TRACE(speed);
    const auto world = MakeSpace(GetParam(), Vector3::Zero());
    Random random(1);
    std::vector<Command> commands;
    for (int i = 0; i < kRow * kRow * kRow; ++i) {
      EntityDesc ball = Ball(kApart * Vector3(i % kRow, i / kRow % kRow, i / kRow / kRow), 0.2);
      ball.rigid_body->linear_velocity = speed * random.Direction();
      commands.push_back(CreateEntity{ball});
    }
    ASSERT_TRUE(world->Apply(commands).ok());
    // So many as each may find without much ado.
    world->set_budget({.pairs = 3 * kRow * kRow * kRow});
    for (int i = 0; i < 10; ++i) {
      ASSERT_TRUE(world->Step().ok()) << i;
      // They fly as long as most have nobody in their way: of ways as long as they are apart, most have.
      if (speed * kStep < kApart / 2) {
        EXPECT_GT(world->stats().entities_in_flight, commands.size() * 3 / 4);
      }
    }
  }
}

TEST_P(Flight, EndsWhereSomethingIsInTheWay) {
  const auto world = MakeSpace(GetParam(), Vector3::Zero());
  Require(*world, Feature::kContacts);
  EntityDesc ball = Ball({0, 0, 0});
  ball.rigid_body->linear_velocity = {6, 0, 0};
  const EntityId flyer = Add(*world, ball);
  const EntityId other = Add(*world, Ball({3, 0, 0}));
  Steps(*world, 1);
  EXPECT_EQ(world->stats().entities_in_flight, 2u);

  Steps(*world, 60);

  // Without restitution two balls of one mass go on together.
  EXPECT_NEAR(VelocityOf(*world, flyer).x(), 3, kRounding);
  EXPECT_NEAR(VelocityOf(*world, other).x(), 3, kRounding);
}

TEST_P(Flight, IsMetByWhatComesInTheMiddleOfAStep) {
  const auto world = MakeSpace(GetParam(), Vector3::Zero());
  Require(*world, Feature::kContacts);
  const EntityId flyer = Add(*world, Ball({0, 0, 0}));
  EntityDesc pusher = Ball({-1.6, 0, 0});
  pusher.rigid_body->motion_type = MotionType::kKinematic;
  pusher.rigid_body->linear_velocity = {50, 0, 0};
  Add(*world, pusher);

  // It covers 0.83 m, and the gap of 0.6 m keeps it out of the flyer's region when the step begins.
  Steps(*world, 1);

  EXPECT_EQ(world->stats().entities_in_flight, 0u);
  EXPECT_NEAR(VelocityOf(*world, flyer).x(), 50, 50 * kRounding);
}

}  // namespace
}  // namespace genphys::testing

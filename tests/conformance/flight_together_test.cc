// What all goes the same way, far from what rests, is looked for as seen from what goes along: how fast it goes changes
// nothing.
#include <algorithm>
#include <vector>

#include "conformance/engine_test.h"
#include "support/random.h"
#include "support/tolerances.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(FlightTogether, Claim::kEnginesAgree);

constexpr double kStep = 1.0 / 60;

std::unique_ptr<World> MakeFlight(const std::string& engine, const Vector3& gravity, bool ground_plane = false) {
  WorldDesc desc{.engine = engine, .gravity = gravity, .ground_plane = ground_plane};
  desc.default_auto_disable.enabled = false;
  auto world = MakeWorld(desc);
  world->set_record_stats(true);
  return world;
}

// Elastic balls without friction, three in each direction, that go `common` and 1 m/s each its own way.
std::vector<EntityId> AddGas(World& world, const Vector3& common) {
  Random random(1);
  std::vector<EntityId> balls;
  for (int i = 0; i < 27; ++i) {
    const Vector3 place(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    EntityDesc ball = Ball(1.5 * place, 0.3);
    ball.rigid_body->linear_velocity = common - 0.5 * place + random.Vector(0.5);
    ball.rigid_body->geometries[0].material.restitution = 1;
    ball.rigid_body->geometries[0].material.friction = 0;
    balls.push_back(Add(world, ball));
  }
  return balls;
}

TEST_P(FlightTogether, OfWhatMeetsIsAsItIsWhereNothingGoesAlong) {
  constexpr int kSteps = 120;
  const Vector3 common(150, -80, 200);
  const auto still = MakeFlight(GetParam(), Vector3::Zero()), swift = MakeFlight(GetParam(), Vector3::Zero());
  Require(*still, Feature::kContacts);
  const std::vector<EntityId> balls = AddGas(*still, Vector3::Zero());
  AddGas(*swift, common);
  bool has_met = false;
  for (int i = 0; i < kSteps; ++i) {
    Steps(*still, 1);
    Steps(*swift, 1);
    has_met = has_met || still->stats().entities_in_engine > 0;
  }
  ASSERT_TRUE(has_met);
  for (const EntityId ball : balls) {
    const Vector3 along = PositionOf(*swift, ball) - kSteps * kStep * common;
    // Each of some blows multiplies what was rounded by how far balls fly between them, in radii.
    EXPECT_LT((along - PositionOf(*still, ball)).norm(), 1e-6);
    EXPECT_LT((VelocityOf(*swift, ball) - common - VelocityOf(*still, ball)).norm(), 1e-6);
  }
}

// Who is damped falls behind those that go along, within each step.
TEST_P(FlightTogether, OfWhatIsDampedMeetsAsInTheEngine) {
  constexpr double kSpeed = 100;
  for (double behind = 1.02; behind < 2; behind += 0.02) {
    SCOPED_TRACE(behind);
    const auto lanes = MakeFlight(GetParam(), Vector3::Zero()), engine = MakeFlight(GetParam(), Vector3::Zero());
    Require(*lanes, Feature::kContacts);
    StepperDesc stepper = engine->scene().world.stepper;
    stepper.engine_only = true;
    Do(*engine, SetStepper{stepper});
    std::vector<EntityId> balls;
    for (const auto& world : {lanes.get(), engine.get()}) {
      for (const bool is_damped : {false, true}) {
        EntityDesc ball = Ball({is_damped ? behind : 0, 0, 0});
        ball.rigid_body->linear_velocity = {kSpeed, 0, 0};
        ball.rigid_body->linear_damping = is_damped ? 5 : 0;
        ball.rigid_body->geometries[0].material.restitution = 1;
        balls.push_back(Add(*world, ball));
      }
    }
    for (int i = 0; i < 10; ++i) {
      Steps(*lanes, 1);
      Steps(*engine, 1);
      EXPECT_GE(PositionOf(*lanes, balls[1]).x() - PositionOf(*lanes, balls[0]).x(), 1 - kTouch);
    }
    for (const EntityId ball : {balls[0], balls[1]}) {
      EXPECT_NEAR(VelocityOf(*lanes, ball).x(), VelocityOf(*engine, ball).x(), 1e-3 * kSpeed);
    }
  }
}

TEST_P(FlightTogether, EndsOnTheFloor) {
  constexpr double kRadius = 0.5, kHeight = 200;
  const auto world = MakeFlight(GetParam(), {0, 0, -9.81}, true);
  Require(*world, Feature::kContacts);
  std::vector<EntityId> balls;
  for (int i = 0; i < 27; ++i) {
    balls.push_back(Add(*world, Ball({2.0 * (i % 3), 2.0 * (i / 3 % 3), kHeight + 2.0 * (i / 9)}, kRadius)));
  }
  double lowest = kHeight;
  while (world->layer_state().simulation_time < 10) {
    Steps(*world, 1);
    for (const EntityId ball : balls) lowest = std::min(lowest, PositionOf(*world, ball).z());
  }
  // They come at 62 m/s, a metre in each step.
  EXPECT_GE(lowest, kRadius - kTouch);
  // Columns of three may stay as they come.
  for (const EntityId ball : balls) EXPECT_LT(PositionOf(*world, ball).z(), 5 * kRadius + kTouch);
}

TEST_P(FlightTogether, IsSeenWhereItIs) {
  const auto world = MakeFlight(GetParam(), {0, 0, -9.81});
  Require(*world, Feature::kRayCasts);
  Require(*world, Feature::kShapeQueries);
  const std::vector<EntityId> balls = AddGas(*world, {0, 0, -50});
  Steps(*world, 5);
  ASSERT_EQ(world->stats().entities_in_flight, balls.size());
  for (const EntityId ball : balls) {
    const Vector3 place = PositionOf(*world, ball);
    const std::vector<Ray> rays{{.origin = place + Vector3(0.31, 0, 0), .translation = {-0.2, 0, 0}},
                                {.origin = place + Vector3(0.31, 0, 0), .translation = {0.05, 0, 0}}};
    const auto hits = world->CastRays(rays);
    ASSERT_TRUE(hits.ok());
    EXPECT_EQ((*hits)[0].entity, ball);
    EXPECT_NE((*hits)[1].entity, ball);
    const Pose pose{.position = place};
    const auto overlaps = world->FindOverlaps(Sphere{0.01}, {&pose, 1});
    ASSERT_TRUE(overlaps.ok());
    ASSERT_EQ(overlaps->front().size(), 1u);
    EXPECT_EQ(overlaps->front().front().entity, ball);
    const auto closest = world->FindClosest(Sphere{0.01}, {&pose, 1}, 100);
    ASSERT_TRUE(closest.ok());
    EXPECT_EQ(closest->front().hit.entity, ball);
  }
}

TEST_P(FlightTogether, EndsAtWhatIsPutInItsWay) {
  constexpr double kRadius = 0.5, kSpeed = 100;
  for (const bool moved : {false, true}) {
    SCOPED_TRACE(moved);
    const auto world = MakeFlight(GetParam(), Vector3::Zero());
    Require(*world, Feature::kContacts);
    EntityDesc wall = Body(Box{{20, 20, 0.01}}, {0, 0, 1000});
    wall.rigid_body->motion_type = MotionType::kStatic;
    const EntityId away = moved ? Add(*world, wall) : EntityId();
    std::vector<EntityId> balls;
    for (int i = 0; i < 9; ++i) {
      EntityDesc ball = Ball({2.0 * (i % 3), 2.0 * (i / 3), 0}, kRadius);
      ball.rigid_body->linear_velocity = {0, 0, -kSpeed};
      balls.push_back(Add(*world, ball));
    }
    Steps(*world, 5);
    ASSERT_EQ(world->stats().entities_in_flight, balls.size());
    const double top = PositionOf(*world, balls[0]).z() - kRadius - 0.3;
    const Vector3 place(0, 0, top - 0.01);
    if (moved) {
      Do(*world, SetPose{.id = away, .position = place});
    } else {
      wall.pose.position = place;
      Add(*world, wall);
    }
    Steps(*world, 10);
    for (const EntityId ball : balls) EXPECT_NEAR(PositionOf(*world, ball).z(), top + kRadius, kTouch);
  }
}

}  // namespace
}  // namespace genphys::testing

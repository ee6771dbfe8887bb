// What stands or rolls on something that turns goes round as friction takes it along, in second order of the step.
#include <cmath>

#include "engine_test.h"
#include "support/energy.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Turntables, Claim::kStaticFriction);

constexpr double kGravity = 9.81, kFriction = 0.5;

std::unique_ptr<World> Around(const std::string& engine, int rate) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = 1.0 / rate}};
  desc.ground_plane = false;
  desc.default_material.friction = kFriction;
  desc.default_auto_disable.enabled = false;
  return testing::MakeWorld(desc);
}

// Its top is level at zero; it turns about z.
EntityDesc Table(double turn) {
  EntityDesc table = Block({0, 0, -0.5}, {6, 6, 0.5});
  table.rigid_body->motion_type = MotionType::kKinematic;
  table.rigid_body->angular_velocity = {0, 0, turn};
  return table;
}

double RadiusOf(const World& world, EntityId id) { return PositionOf(world, id).head<2>().norm(); }

// With 0.85 of the turn at which friction cannot hold it: without the bend of its way in mind it goes out by
// omega^2 r h / 2, which is 15 mm in each second at 60 steps.
TEST_P(Turntables, HoldABoxWhereItIs) {
  Proves({Claim::kBox});
  constexpr double kRadius = 1, kHalf = 0.1;
  const double turn = 0.85 * std::sqrt(kFriction * kGravity / kRadius);
  for (const int rate : {30, 60, 240}) {
    SCOPED_TRACE(rate);
    const auto world = Around(GetParam(), rate);
    Require(*world, Feature::kContacts);
    Add(*world, Table(turn));
    EntityDesc box = Body(Box{{0.05, 0.05, kHalf}}, {kRadius, 0, kHalf});
    box.rigid_body->linear_velocity = {0, turn * kRadius, 0};
    box.rigid_body->angular_velocity = {0, 0, turn};
    const EntityId id = Add(*world, box);
    Steps(*world, 5 * rate);
    EXPECT_NEAR(RadiusOf(*world, id), kRadius, 5e-4);
  }
}

TEST_P(Turntables, ThrowOffABoxThatFrictionCannotHold) {
  Proves({Claim::kBox});
  constexpr double kRadius = 1, kHalf = 0.1;
  const double turn = 1.1 * std::sqrt(kFriction * kGravity / kRadius);
  const auto world = Around(GetParam(), 60);
  Require(*world, Feature::kContacts);
  Add(*world, Table(turn));
  EntityDesc box = Body(Box{{0.05, 0.05, kHalf}}, {kRadius, 0, kHalf});
  box.rigid_body->linear_velocity = {0, turn * kRadius, 0};
  box.rigid_body->angular_velocity = {0, 0, turn};
  const EntityId id = Add(*world, box);
  Steps(*world, 120);
  EXPECT_GT(RadiusOf(*world, id), 2 * kRadius);
}

// A solid ball that rolls on it goes in a circle, at 2/7 of the table's turn wherever it begins and however fast:
// Weltner, "Stable circular orbits of freely moving balls on rotating discs", Am. J. Phys. 47 (1979).
TEST_P(Turntables, LeadABallInCircles) {
  Proves({Claim::kSphere});
  constexpr double kTurn = 3, kRadius = 0.1;
  const Vector3 up = Vector3::UnitZ(), start(1, 0, kRadius), velocity(0, -0.5, 0);
  for (const int rate : {60, 240}) {
    SCOPED_TRACE(rate);
    const auto world = Around(GetParam(), rate);
    Require(*world, Feature::kContacts);
    Add(*world, Table(kTurn));
    EntityDesc ball = Ball(start, kRadius);
    ball.rigid_body->linear_velocity = velocity;
    // As the table moves where it stands on it.
    ball.rigid_body->angular_velocity = up.cross(velocity - kTurn * up.cross(start)) / kRadius;
    const EntityId id = Add(*world, ball);
    const double round = kTurn * 2 / 7;
    const Vector3 center = start + up.cross(velocity) / round;
    for (int second = 1; second <= 5; ++second) {
      Steps(*world, rate);
      const Vector3 place = center + Eigen::AngleAxisd(round * second, up) * (start - center);
      EXPECT_NEAR((PositionOf(*world, id) - place).norm(), 0, 5e-5 * second) << second;
    }
  }
}

// Nothing tells where those touch that have one middle, nor what their surfaces do there.
TEST_P(Turntables, LeaveBallsThatSpinWithinEachOtherFinite) {
  Proves({Claim::kSphere});
  const auto world = Around(GetParam(), 60);
  Require(*world, Feature::kContacts);
  for (const double spin : {1e3, -20.0}) {
    EntityDesc ball = Ball({0, 0, 5}, 0.5);
    ball.rigid_body->angular_velocity = {spin, 0, spin};
    Add(*world, ball);
  }
  EXPECT_TRUE(world->Step().ok());
  Steps(*world, 60);
  EXPECT_LT(KineticEnergyOf(*world), 2e5);
}

}  // namespace
}  // namespace genphys::testing

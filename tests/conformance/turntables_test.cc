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

// How far from the middle a box is (m) after `seconds` that begins at 1 m and goes round with a table at `part` of the
// turn at which friction can hold it no longer; and the square of how far (rad) that turns in a substep.
struct Held {
  double radius;
  double square;
};
Held HeldAt(const std::string& engine, int rate, double part, int seconds) {
  constexpr double kHalf = 0.1;
  const double turn = part * std::sqrt(kFriction * kGravity);
  const auto world = Around(engine, rate);
  Require(*world, Feature::kContacts);
  Add(*world, Table(turn));
  EntityDesc box = Body(Box{{0.05, 0.05, kHalf}}, {1, 0, kHalf});
  box.rigid_body->linear_velocity = {0, turn, 0};
  box.rigid_body->angular_velocity = {0, 0, turn};
  const EntityId id = Add(*world, box);
  Steps(*world, seconds * rate);
  return {PositionOf(*world, id).head<2>().norm(), std::pow(turn * SubstepOf(*world), 2)};
}

// Without the bend of its way in mind it goes out by omega^2 r h / 2, which is 15 mm in each second at 60 steps.
TEST_P(Turntables, HoldABoxWhereItIs) {
  Proves({Claim::kBox});
  for (const int rate : {30, 60, 240}) {
    const Held held = HeldAt(GetParam(), rate, 0.85, 5);
    EXPECT_NEAR(held.radius, 1, held.square) << rate;
  }
}

TEST_P(Turntables, ThrowOffABoxThatFrictionCannotHold) {
  Proves({Claim::kBox});
  EXPECT_GT(HeldAt(GetParam(), 60, 1.1, 2).radius, 2);
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
      // Of its way that part which is the square of how far the table turns in a substep.
      const double square = std::pow(kTurn * SubstepOf(*world), 2);
      EXPECT_NEAR((PositionOf(*world, id) - place).norm(), 0, square * velocity.norm() * second) << second;
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
  const double start = KineticEnergyOf(*world);
  Steps(*world, 60);
  // Both fall for a second, of 1 kg, and are pushed apart by some millimetres.
  EXPECT_LE(KineticEnergyOf(*world), start + 1.01 * kGravity * kGravity);
}

}  // namespace
}  // namespace genphys::testing

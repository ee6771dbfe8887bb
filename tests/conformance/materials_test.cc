// How two materials become one, and that what they become is what the engine uses.
#include <algorithm>
#include <cmath>

#include "engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Materials, Claim::kMixingRules);

std::unique_ptr<World> OnFloor(const std::string& engine, const Material& floor) {
  return MakeWorld(WorldDesc{
      .engine = engine, .gravity = {0, 0, -9.81}, .default_material = floor, .recorded_events = {.contacts = true}});
}

/// The first contact point of a crate of `material` that lies on a floor of another.
EventContactPoint Meet(const std::string& engine, const Material& floor, const Material& crate) {
  const auto world = OnFloor(engine, floor);
  EntityDesc desc = Crate({0, 0, 0.5});
  desc.rigid_body->geometries[0].material = crate;
  Add(*world, desc);
  Steps(*world, 1);
  const auto began = Of<ContactBegan>(world->TakeEvents());
  EXPECT_EQ(began.size(), 1u);
  return began.empty() || began[0].points.empty() ? EventContactPoint() : began[0].points[0];
}

TEST_P(Materials, MixByTheGeometricMeanUnlessTold) {
  const EventContactPoint point =
      Meet(GetParam(), {.friction = 0.4, .restitution = 0.2}, {.friction = 0.9, .restitution = 0.8});

  EXPECT_NEAR(point.friction, 0.6, kRounded);
  EXPECT_NEAR(point.restitution, 0.4, kRounded);
}

TEST_P(Materials, MixAsEitherOfThemSays) {
  struct Case {
    Mixing rule;
    double friction;
    double restitution;
  };
  for (const Case& wanted : {Case{Mixing::kAverage, 0.65, 0.5}, Case{Mixing::kMinimum, 0.4, 0.2},
                             Case{Mixing::kMultiply, 0.36, 0.16}, Case{Mixing::kMaximum, 0.9, 0.8}}) {
    const Material plain_floor{.friction = 0.4, .restitution = 0.2}, plain{.friction = 0.9, .restitution = 0.8};
    Material told_floor = plain_floor, told = plain;
    told_floor.friction_mixing = told.friction_mixing = wanted.rule;
    told_floor.restitution_mixing = told.restitution_mixing = wanted.rule;
    // A geometry takes what it leaves open from the world's default, which is the floor's material here.
    for (const auto& point : {Meet(GetParam(), plain_floor, told), Meet(GetParam(), told_floor, plain)}) {
      EXPECT_NEAR(point.friction, wanted.friction, kRounded) << static_cast<int>(wanted.rule);
      EXPECT_NEAR(point.restitution, wanted.restitution, kRounded) << static_cast<int>(wanted.rule);
    }
  }
}

TEST_P(Materials, OfTwoRulesTheLaterOneCounts) {
  const Material minimum{.friction = 0.4, .friction_mixing = Mixing::kMinimum};
  const Material maximum{.friction = 0.9, .friction_mixing = Mixing::kMaximum};

  EXPECT_NEAR(Meet(GetParam(), minimum, maximum).friction, 0.9, kRounded);
  EXPECT_NEAR(Meet(GetParam(), maximum, minimum).friction, 0.9, kRounded);
}

TEST_P(Materials, SlideAsFarAsTheirMixedFrictionSays) {
  Proves({Claim::kKineticFriction});
  constexpr double kSpeed = 3, kGravity = 9.81;
  for (const auto& [rule, friction] : {std::pair{Mixing::kMinimum, 0.2}, {Mixing::kMaximum, 0.8}}) {
    const auto world = OnFloor(GetParam(), {.friction = 0.2});
    EntityDesc crate = Crate({0, 0, 0.5});
    crate.rigid_body->geometries[0].material = {.friction = 0.8, .friction_mixing = rule};
    crate.rigid_body->linear_velocity = {kSpeed, 0, 0};
    const EntityId id = Add(*world, crate);
    Steps(*world, 180);

    const double tolerance = 2 * StopError(friction * kGravity, SubstepOf(*world));
    EXPECT_NEAR(PositionOf(*world, id).x(), kSpeed * kSpeed / (2 * friction * kGravity), tolerance);
  }
}

TEST_P(Materials, BounceAsHighAsTheirMixedRestitutionSays) {
  Proves({Claim::kRestitution});
  constexpr double kHeight = 1, kGravity = 9.81, kStep = 1.0 / 240;
  const double speed = std::sqrt(2 * kGravity * kHeight);
  for (const auto& [rule, restitution] : {std::pair{Mixing::kMinimum, 0.5}, {Mixing::kMaximum, 0.9}}) {
    const auto world = OnFloor(GetParam(), {.restitution = 0.5});
    Do(*world, SetStepper{{.step_size = kStep}});
    EntityDesc ball = Ball({0, 0, 0.5 + kHeight});
    ball.rigid_body->geometries[0].material = {.restitution = 0.9, .restitution_mixing = rule};
    const EntityId id = Add(*world, ball);
    double top = 0;
    bool has_bounced = false;
    for (int i = 0; i < 240; ++i) {
      Steps(*world, 1);
      has_bounced |= VelocityOf(*world, id).z() > 0;
      if (has_bounced) top = std::max(top, PositionOf(*world, id).z() - 0.5);
    }

    const double tolerance = 2 * (ApexMissed(kGravity, kStep) + ImpactDepth(speed, SubstepOf(*world)));
    EXPECT_NEAR(top, restitution * restitution * kHeight, tolerance);
  }
}

// Friction of each is against the slip, and holds nothing across it: else the two press on each other through the body.
TEST_P(Materials, BrakeWhatSlidesAlongAFloorAndAWallByTheSumOfBoth) {
  Proves({Claim::kKineticFriction});
  constexpr double kSpeed = 6, kGravity = 9.81, kTilt = 0.6;  // rad, of gravity towards the wall
  for (const double friction : {0.2, 0.4, 0.6}) {
    for (const double heading : {0.0, 0.8}) {
      const Quaternion turn(Eigen::AngleAxisd(heading, Vector3::UnitZ()));
      WorldDesc desc{.engine = GetParam(),
                     .gravity = turn * Vector3(0, -kGravity * std::sin(kTilt), -kGravity * std::cos(kTilt))};
      desc.ground_plane = false;
      desc.default_material.friction = friction;
      const auto world = testing::MakeWorld(desc);
      Require(*world, Feature::kContacts);
      for (const Vector3& place : {Vector3(0, 0, -1), Vector3(0, -1.5, 0)}) {
        EntityDesc side = Block(turn * place, {50, 1, 1});
        if (place.y() == 0) side = Block(turn * place, {50, 50, 1});
        side.pose.orientation = turn;
        Add(*world, side);
      }
      // So long and flat that no braking tips it over.
      EntityDesc sliding = Body(Box{{0.6, 0.2, 0.2}}, turn * Vector3(0, -0.3, 0.2));
      sliding.pose.orientation = turn;
      sliding.rigid_body->linear_velocity = turn * Vector3(kSpeed, 0, 0);
      const EntityId crate = Add(*world, sliding);

      Steps(*world, 180);

      const double braked = friction * kGravity * (std::sin(kTilt) + std::cos(kTilt));
      const double way = kSpeed * kSpeed / (2 * braked);
      EXPECT_NEAR((turn.conjugate() * PositionOf(*world, crate)).x(), way, 0.02 * way) << friction << ", " << heading;
      EXPECT_LE(VelocityOf(*world, crate).norm(), SweptSpeed(kGravity, SubstepOf(*world)));
    }
  }
}

}  // namespace
}  // namespace genphys::testing

// Overlaps and the gaps of joints are taken away as told, in seconds, m/s and m, on every engine.
#include <cmath>

#include "engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Corrections, Claim::kErrorCorrection);

constexpr double kGravity = 9.81, kRadius = 0.5;

std::unique_ptr<World> WithDefault(const std::string& engine, const ErrorCorrection& correction) {
  return MakeWorld(WorldDesc{.engine = engine,
                             .gravity = {0, 0, -kGravity},
                             .default_auto_disable = {.enabled = false},
                             .default_error_correction = correction});
}

EntityId AddOverlapping(World& world, double depth, const ErrorCorrection& correction = {}, double x = 0) {
  EntityDesc ball = Ball({x, 0, kRadius - depth}, kRadius);
  ball.rigid_body->error_correction = correction;
  return Add(world, ball);
}

double DepthOf(const World& world, EntityId id) { return kRadius - PositionOf(world, id).z(); }

// An engine that corrects by velocities is one substep late, in which the ball falls besides.
double LateBy(const World& world, double speed) {
  const double substep = SubstepOf(world);
  return 2 * (speed * substep + kGravity * substep * substep);
}

TEST_P(Corrections, TakeAnOverlapAwayInItsTime) {
  constexpr double kDepth = 0.05, kTime = 0.5;
  const auto world = WithDefault(GetParam(), {.time_constant = kTime});
  const EntityId ball = AddOverlapping(*world, kDepth);
  for (int steps = 6; steps <= 24; steps += 6) {
    Steps(*world, 6);
    const double expected = kDepth * std::exp(-steps / 60.0 / kTime), tolerance = LateBy(*world, kDepth / kTime);
    ASSERT_LT(tolerance, expected / 2) << "or nothing would be told by it";
    EXPECT_NEAR(DepthOf(*world, ball), expected, tolerance) << steps;
  }
}

TEST_P(Corrections, AreNoFasterThanTold) {
  constexpr double kDepth = 0.2, kSpeed = 0.1;
  const auto world = WithDefault(GetParam(), {.time_constant = 0.0, .speed_max = kSpeed});
  const EntityId ball = AddOverlapping(*world, kDepth);

  Steps(*world, 60);

  // It may begin a substep late.
  EXPECT_NEAR(DepthOf(*world, ball), kDepth - kSpeed, 2 * kSpeed * SubstepOf(*world));
  Steps(*world, 120);
  EXPECT_NEAR(DepthOf(*world, ball), 0, kTouch);
}

TEST_P(Corrections, KeepWhomTheyPushAwakeUntilItIsOut) {
  Proves({Claim::kSleeping});
  constexpr double kDepth = 0.2, kSpeed = 0.05;
  const auto world = MakeWorld();
  const EntityId ball = AddOverlapping(*world, kDepth, {.speed_max = kSpeed});

  Steps(*world, static_cast<int>(0.9 * kDepth / kSpeed * 60));
  EXPECT_FALSE(Asleep(*world, ball));
  Steps(*world, 120);

  EXPECT_TRUE(Asleep(*world, ball));
  EXPECT_NEAR(DepthOf(*world, ball), 0, kTouch);
}

TEST_P(Corrections, LeaveTheSlopAlone) {
  constexpr double kDepth = 0.05, kSlop = 0.02;
  const auto world = WithDefault(GetParam(), {.time_constant = 0.02, .slop = kSlop});
  const EntityId deep = AddOverlapping(*world, kDepth), shallow = AddOverlapping(*world, kSlop / 2, {}, 3);

  Steps(*world, 120);

  EXPECT_NEAR(DepthOf(*world, deep), kSlop, kTouch);
  EXPECT_NEAR(DepthOf(*world, shallow), kSlop / 2, kTouch);
}

TEST_P(Corrections, OfTwoEntitiesTheGentlerCounts) {
  constexpr double kDepth = 0.03, kTime = 0.2, kShallow = 5e-3;
  // The floor has the world's.
  const auto world = WithDefault(GetParam(), {.time_constant = 0.01});
  const EntityId ball = AddOverlapping(*world, kDepth, {.time_constant = kTime});
  const EntityId other = AddOverlapping(*world, kShallow, {.time_constant = 0.001}, 3);

  Steps(*world, 12);

  ASSERT_LT(LateBy(*world, kDepth / kTime), kDepth * std::exp(-1) / 2);
  EXPECT_NEAR(DepthOf(*world, ball), kDepth * std::exp(-1), LateBy(*world, kDepth / kTime));
  EXPECT_LE(DepthOf(*world, other), kShallow * std::exp(-12.0 / 60 / 0.01) + kTouch);
}

TEST_P(Corrections, CloseTheGapOfAJointInItsTime) {
  constexpr double kGap = 0.1, kTime = 0.25;
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  EntityDesc ball = Ball({0, 0, 0});
  ball.rigid_body->error_correction = {.time_constant = kTime};
  const EntityId id = Add(*world, ball);
  const JointId joint = Join(*world, {.entity_b = {id, {}},
                                      .frame_in_a = Pose{{kGap, 0, 0}, Quaternion::Identity()},
                                      .frame_in_b = Pose{},
                                      .kind = BallJoint{}});
  for (int steps = 15; steps <= 60; steps += 15) {
    Steps(*world, 15);
    const double expected = kGap * std::exp(-steps / 60.0 / kTime);
    EXPECT_NEAR(GapOf(*world, joint), expected, kDirect * kGap) << steps;
  }
}

TEST_P(Corrections, ChangeLiveAndAreKeptByAnotherEngine) {
  constexpr double kDepth = 0.2, kSpeed = 0.05;
  const auto world = WithDefault(GetParam(), {});
  const EntityId ball = AddOverlapping(*world, kDepth, {.speed_max = 0.0});
  Steps(*world, 30);
  EXPECT_NEAR(DepthOf(*world, ball), kDepth, kTouch) << "at no speed at all";
  const uint64_t before = world->StateHash();
  EntityDesc desc = Ball({0, 0, 0});
  desc.rigid_body->error_correction = {.speed_max = kSpeed};
  Do(*world, UpdateEntity{ball, desc, {static_cast<uint32_t>(EntityField::kErrorCorrection)}});
  EXPECT_NE(world->StateHash(), before);

  for (const std::string& engine : {GetParam(), OtherEngine(GetParam())}) {
    Do(*world, SetEngine{engine});
    Steps(*world, 60);
  }

  constexpr double seconds = 2;
  // Each engine may begin a substep late.
  EXPECT_NEAR(DepthOf(*world, ball), kDepth - kSpeed * seconds, 2 * kSpeed * seconds * SubstepOf(*world));
}

TEST_P(Corrections, AreRefusedWhereThereAreNoContactsToCorrect) {
  const auto world = WithDefault(GetParam(), {});
  AddOverlapping(*world, 0, {.slop = 0.01});
  const Command change = SetEngine{"ballistic"};

  const auto refused = RefusalOf(world->Apply({&change, 1}).status());

  ASSERT_TRUE(refused.has_value());
  EXPECT_EQ(refused->reason, Reason::kUnsupportedFeature);
}

TEST_P(Corrections, LeaveAloneWhoGetsOutByItself) {
  Proves({Claim::kRestitution});
  const auto world = testing::MakeWorld(WorldDesc{.engine = GetParam(), .gravity = Vector3::Zero()});
  EntityDesc ball = Ball({0, 0, kRadius - 1e-3}, kRadius);
  ball.rigid_body->linear_velocity = {0, 0, 1};
  ball.rigid_body->geometries[0].material.restitution = 1;
  ball.rigid_body->geometries[0].material.restitution_mixing = Mixing::kMaximum;
  const EntityId id = Add(*world, ball);
  for (int step = 1; step <= 5; ++step) {
    Steps(*world, 1);
    EXPECT_NEAR(PositionOf(*world, id).z(), kRadius - 1e-3 + step / 60.0, kRounded);
    EXPECT_NEAR(VelocityOf(*world, id).z(), 1, kRounded);
  }
}

}  // namespace
}  // namespace genphys::testing

// What becomes of joints: breaking, sleeping, deletion, a change of engine.
#include <cmath>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsLife);

constexpr double kGravity = 9.81;

TEST_P(JointsLife, AJointBreaksInTheStepInWhichItHoldsTooMuch) {
  Proves({Claim::kJointBreak, Claim::kJointBrokeEvents});
  constexpr double kLimit = 15, kPull = 10;
  const auto world = MakeSpace(GetParam());
  const EntityId weight = Add(*world, Ball({0, 0, -1}, 0.2));
  JointDesc rope = ToWorld(weight, FixedJoint{});
  rope.break_force = kLimit;
  const JointId joint = Join(*world, rope);
  Steps(*world, 30);
  world->TakeEvents();
  Do(*world, ApplyForce{.id = weight, .force = {0, 0, -kPull}, .steps = 5});
  Steps(*world, 1);

  const std::vector<Event> events = world->TakeEvents();
  const std::vector<JointBroke> broken = Of<JointBroke>(events);
  ASSERT_EQ(broken.size(), 1u);
  EXPECT_EQ(events.back().step, 31u);
  EXPECT_EQ(broken[0].joint, joint);
  EXPECT_EQ(broken[0].pair, (EntityPair{EntityId(), weight}));
  EXPECT_NEAR(broken[0].force, kGravity + kPull, kDirect * (kGravity + kPull));
  EXPECT_EQ(RefusalOf(world->CheckId(joint, ""))->reason, Reason::kStaleId);
  Steps(*world, 30);
  EXPECT_LT(PositionOf(*world, weight).z(), -2);
}

TEST_P(JointsLife, AJointBreaksByTorqueAlone) {
  Proves({Claim::kJointBreak});
  const auto world = MakeSpace(GetParam());
  const EntityId beam = Add(*world, Body(Box{{1, 0.1, 0.1}}, {1, 0, 0}, 1));
  JointDesc weld = ToWorld(beam, FixedJoint{});
  weld.break_torque = kGravity + 0.5;
  Join(*world, weld);
  Steps(*world, 30);
  EXPECT_TRUE(Of<JointBroke>(world->TakeEvents()).empty()) << "it carries one metre times its weight";
  Do(*world, ApplyForce{.id = beam, .torque = {0, 1, 0}});
  Steps(*world, 1);
  const std::vector<JointBroke> broken = Of<JointBroke>(world->TakeEvents());
  ASSERT_EQ(broken.size(), 1u);
  EXPECT_NEAR(broken[0].torque, kGravity + 1, kDirect * (kGravity + 1));
}

TEST_P(JointsLife, WhatIsJoinedSleepsAndWakesTogether) {
  Proves({Claim::kSleeping});
  const auto world = MakeWorld();
  const EntityId a = Add(*world, Crate({0, 0, 0.5})), b = Add(*world, Crate({1.5, 0, 0.5}));
  DistanceJoint rope;
  rope.axis.limits.upper = 3;
  const JointId joint = Join(*world, Between(a, b, rope));
  // One of them turns for a second, far from touching the other.
  for (int i = 0; i < 60; ++i) {
    Do(*world, SetVelocity{.id = a, .angular = Vector3(0, 0, 1)});
    Steps(*world, 1);
    ASSERT_FALSE(Asleep(*world, b)) << "step " << i;
  }
  Steps(*world, 240);
  ASSERT_TRUE(Asleep(*world, a));
  ASSERT_TRUE(Asleep(*world, b));

  Do(*world, ApplyImpulse{.id = a, .linear = {0, 0, 0.1}});
  EXPECT_FALSE(Asleep(*world, b)) << "the push goes through the joint";
  Steps(*world, 240);
  ASSERT_TRUE(Asleep(*world, a));

  Do(*world, DeleteJoint{joint});
  EXPECT_FALSE(Asleep(*world, a));
  EXPECT_FALSE(Asleep(*world, b));
}

TEST_P(JointsLife, ASlowMotorIsNotPutToSleep) {
  Proves({Claim::kSleeping, Claim::kJointMotor});
  const auto world = MakeWorld();
  const EntityId hand = Add(*world, Ball({0, 0, 5}));
  HingeJoint clock;
  clock.axis.motor = Motor{.target_velocity = 0.01};
  const JointId joint = Join(*world, ToWorld(hand, clock, Pose{{0, 0, 5}, {1, 0, 0, 0}}));
  Steps(*world, 600);
  EXPECT_FALSE(Asleep(*world, hand));
  EXPECT_NEAR(StateOf(*world, joint).positions[5], 0.1, kDirect * 0.1);
}

TEST_P(JointsLife, WhoeverHangsOnWhatSetsOutWakesUp) {
  Proves({Claim::kSleeping});
  const auto world = MakeWorld();
  EntityDesc lift = Crate({0, 0, 5});
  lift.rigid_body->motion_type = MotionType::kKinematic;
  const EntityId crane = Add(*world, lift), load = Add(*world, Ball({0, 0, 3}));
  const JointId joint = Join(*world, Between(crane, load, BallJoint{}));
  Steps(*world, 240);
  ASSERT_TRUE(Asleep(*world, load));
  Do(*world, SetVelocity{.id = crane, .linear = Vector3(0, 0, 1)});
  Steps(*world, 60);
  EXPECT_NEAR(PositionOf(*world, load).z(), 4, kDirect);
  EXPECT_LE(GapOf(*world, joint), kDirect);
}

TEST_P(JointsLife, AnEntityTakesItsJointsWithIt) {
  Proves({Claim::kJointChange});
  const auto world = MakeWorld();
  const EntityId top = Add(*world, Ball({0, 0, 8})), bottom = Add(*world, Ball({0, 0, 6}));
  const JointId hook = Join(*world, ToWorld(top, BallJoint{}, Pose{{0, 0, 9}, {1, 0, 0, 0}}));
  const JointId link = Join(*world, Between(top, bottom, BallJoint{}));
  Steps(*world, 240);
  ASSERT_TRUE(Asleep(*world, bottom));
  Do(*world, DeleteEntity{top});

  EXPECT_EQ(world->joint_count(), 0u);
  for (const JointId id : {hook, link}) {
    EXPECT_EQ(RefusalOf(world->CheckId(id, ""))->reason, Reason::kStaleId);
  }
  Steps(*world, 30);
  EXPECT_LT(PositionOf(*world, bottom).z(), 5.5);
}

TEST_P(JointsLife, WhatLeavesTheWorldLetsGo) {
  Proves({Claim::kBounds});
  const auto world = MakeSpace(GetParam());
  const EntityId fast = Add(*world, Ball({0, 0, 0})), slow = Add(*world, Ball({0, 0, 3}));
  DistanceJoint rope;
  rope.axis.limits.upper = 5;
  Join(*world, Between(fast, slow, rope));
  Do(*world, SetPose{fast, Vector3(1e7, 0, 0), {}});
  Do(*world, SetPose{slow, Vector3(1e7 - 3, 0, 0), {}});
  Do(*world, SetVelocity{.id = fast, .linear = Vector3(10, 0, 0)});
  Steps(*world, 2);
  ASSERT_EQ(Of<EntityFaulted>(world->TakeEvents()).size(), 1u);
  Steps(*world, 60);
  EXPECT_FALSE(world->faulted());
  EXPECT_LT(VelocityOf(*world, slow).z(), -9) << "nothing holds it";
}

TEST_P(JointsLife, AChainSurvivesADifferentEngineForEachStep) {
  Proves({Claim::kEngineChange});
  constexpr double kDrift = 5e-3;  // m, promised
  const auto world = MakeSpace(GetParam());
  const Vector3 along(std::sin(0.5), 0, -std::cos(0.5));
  std::vector<JointId> joints;
  EntityId above;
  for (int i = 0; i < 10; ++i) {
    EntityDesc link = Body(Capsule{0.05, 0.15}, (0.4 * i + 0.2) * along);
    link.pose.orientation = Quaternion::FromTwoVectors(-Vector3::UnitZ(), along);
    const EntityId id = Add(*world, link);
    JointDesc joint = Between(above, id, BallJoint{}, Pose{{0, 0, i == 0 ? 0 : -0.2}, {1, 0, 0, 0}});
    if (i == 5) {
      joint.kind = HingeJoint{};
      joint.frame_in_a = FrameAlong(Vector3::UnitY(), {0, 0, -0.2});
    }
    joints.push_back(Join(*world, joint));
    above = id;
  }
  for (int step = 0; step < 600; ++step) {
    Do(*world, SetEngine{step % 2 == 0 ? OtherEngine(GetParam()) : GetParam()});
    Steps(*world, 1);
    for (const JointId joint : joints) ASSERT_LE(GapOf(*world, joint), kDrift) << "step " << step;
  }
}

TEST_P(JointsLife, TurnsAndTargetsSurviveAChangeOfEngine) {
  Proves({Claim::kEngineChange});
  const auto world = MakeSpace(GetParam());
  const EntityId wheel = Add(*world, Ball({0, 0, 0}));
  HingeJoint hinge;
  hinge.axis.motor = Motor{.target_velocity = 9};
  const JointId joint = Join(*world, ToWorld(wheel, hinge));
  Steps(*world, 60);
  Do(*world, SetEngine{OtherEngine(GetParam())});
  EXPECT_NEAR(StateOf(*world, joint).positions[5], 9, kDirect * 9);
  Do(*world, SetEngine{"none"});
  Steps(*world, 10);
  Do(*world, SetEngine{GetParam()});
  Steps(*world, 60);
  EXPECT_NEAR(StateOf(*world, joint).positions[5], 18, kDirect * 18);
}

TEST_P(JointsLife, AResetBringsBackWhatWasJoined) {
  Proves({Claim::kJointChange});
  const auto world = MakeSpace(GetParam());
  const EntityId a = Add(*world, Ball({0, 0, 0})), b = Add(*world, Ball({0, 0, -0.9}));
  const JointId hook = Join(*world, ToWorld(a, BallJoint{}));
  Join(*world, Between(a, b, BallJoint{}));
  const uint64_t before = world->StateHash();
  Steps(*world, 10);
  const uint64_t after = world->StateHash();
  Do(*world, DeleteJoint{hook});
  Steps(*world, 10);
  world->Reset();
  EXPECT_EQ(world->joint_count(), 2u);
  EXPECT_EQ(world->StateHash(), before);
  Steps(*world, 10);
  EXPECT_EQ(world->StateHash(), after);
  EXPECT_TRUE(world->contacts().pairs.empty()) << "they overlap, and are joined";
}

}  // namespace
}  // namespace genphys::testing

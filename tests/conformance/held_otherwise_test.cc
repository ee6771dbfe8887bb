// What holds or drives a body is changed between two steps: from there on the body goes as if it had always been so.
#include <cmath>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(HeldOtherwise);

constexpr double kGravity = 9.81, kStep = 1.0 / 60;
constexpr double kFriction = 0.4;
// m: support that is taken away is promised to be felt at once to this.
constexpr double kAtOnce = 1e-5;

std::unique_ptr<World> OnFloor(const std::string& engine) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = kStep}};
  desc.default_material.friction = kFriction;
  desc.ground_plane = false;
  std::unique_ptr<World> world = MakeWorld(desc);
  Require(*world, Feature::kContacts);
  return world;
}

/// Its top at z = 0.
EntityDesc Floor(MotionType type = MotionType::kStatic) {
  EntityDesc floor = Block({0, 0, -0.5}, {20, 20, 0.5});
  floor.rigid_body->motion_type = type;
  return floor;
}

/// m, above the floor.
double Fallen(double seconds) { return kGravity * seconds * seconds / 2; }

TEST_P(HeldOtherwise, ALiftThatDropsLeavesWhatItCarriedInFreeFall) {
  Proves({Claim::kKinematicPush});
  const auto world = OnFloor(GetParam());
  const EntityId lift = Add(*world, Floor(MotionType::kKinematic));
  std::vector<EntityId> stack;
  for (int i = 0; i < 3; ++i) stack.push_back(Add(*world, Crate({0, 0, 0.5 + i})));
  const EntityId alone = Add(*world, Crate({5, 0, 0.5}));
  Steps(*world, 60);
  Do(*world, SetVelocity{.id = lift, .linear = Vector3(0, 0, -8)});
  Steps(*world, 30);
  EXPECT_NEAR(PositionOf(*world, alone).z(), 0.5 - Fallen(0.5), kAtOnce);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(PositionOf(*world, stack[static_cast<size_t>(i)]).z(), 0.5 + i - Fallen(0.5), (i + 2) * kTouch) << i;
  }
}

// That it went so fast before, with nobody on it, says nothing of how it carries now.
TEST_P(HeldOtherwise, ALiftThatWentDownEmptyBeforeDropsLikeOneThatStood) {
  Proves({Claim::kKinematicPush, Claim::kEngineChange});
  const Vector3 drop(0, 0, -8);
  for (const bool is_engine_new : {false, true}) {
    const auto world = OnFloor(GetParam());
    EntityDesc floor = Floor(MotionType::kKinematic);
    floor.pose.position.z() += 8 * 0.5;
    const EntityId lift = Add(*world, floor);
    const EntityId crate = Add(*world, Crate({0, 0, 10}));
    Do(*world, SetVelocity{.id = lift, .linear = drop});
    Steps(*world, 30);
    Do(*world, SetVelocity{.id = lift, .linear = Vector3(0, 0, 0)});
    Steps(*world, 240);
    ASSERT_NEAR(PositionOf(*world, crate).z(), 0.5, kTouch);
    if (is_engine_new) {
      Do(*world, SetEngine{"none"});
      Do(*world, SetEngine{GetParam()});
    }
    const double start = PositionOf(*world, crate).z();
    Do(*world, SetVelocity{.id = lift, .linear = drop});
    Steps(*world, 30);
    EXPECT_NEAR(PositionOf(*world, crate).z(), start - Fallen(0.5), kAtOnce) << is_engine_new;
  }
}

TEST_P(HeldOtherwise, WhatARisingLiftCarriedFliesOnWhenItStops) {
  Proves({Claim::kKinematicPush, Claim::kKinematicLed});
  constexpr double kSpeed = 2;
  for (const bool is_led : {false, true}) {
    const auto world = OnFloor(GetParam());
    const EntityId lift = Add(*world, Floor(MotionType::kKinematic));
    const EntityId crate = Add(*world, Crate({0, 0, 0.5}));
    Steps(*world, 10);
    if (is_led) {
      Do(*world, SetPose{.id = lift, .position = Vector3(0, 0, -0.5 + kSpeed * 0.5), .over_steps = 30});
      Steps(*world, 30);
    } else {
      Do(*world, SetVelocity{.id = lift, .linear = Vector3(0, 0, kSpeed)});
      Steps(*world, 30);
      Do(*world, SetVelocity{.id = lift, .linear = Vector3(0, 0, 0)});
    }
    Steps(*world, 12);
    EXPECT_NEAR(PositionOf(*world, crate).z(), 0.5 + kSpeed * 0.5 + kSpeed * 0.2 - Fallen(0.2), kAtOnce) << is_led;
  }
}

TEST_P(HeldOtherwise, ABeltThatTurnsRoundBrakesAtOnce) {
  Proves({Claim::kSurfaceVelocity, Claim::kLiveChange});
  const auto world = OnFloor(GetParam());
  EntityDesc floor = Floor();
  floor.rigid_body->geometries[0].surface_velocity = {9, 0, 0};
  const EntityId belt = Add(*world, floor);
  const EntityId crate = Add(*world, Crate({0, 0, 0.5}));
  Steps(*world, 30);
  floor.rigid_body->geometries[0].surface_velocity = {-9, 0, 0};
  Do(*world, UpdateEntity{.id = belt, .entity = floor, .fields = {static_cast<uint32_t>(EntityField::kGeometries)}});
  Steps(*world, 30);
  // Half a second each of the same friction, one way and the other.
  EXPECT_NEAR(PositionOf(*world, crate).x(), kFriction * kGravity / 4, kSwept);
  EXPECT_NEAR(VelocityOf(*world, crate).x(), 0, kSwept);
}

TEST_P(HeldOtherwise, AFloorThatBecomesRougherBrakesMoreAtOnce) {
  Proves({Claim::kKineticFriction, Claim::kLiveChange});
  constexpr double kRough = 0.6, kSpeed = 5, kTime = 0.25;
  for (const bool is_floor : {false, true}) {
    const auto world = OnFloor(GetParam());
    EntityDesc floor = Floor(), sliding = Crate({0, 0, 0.5});
    sliding.rigid_body->linear_velocity = {kSpeed, 0, 0};
    const EntityId ground = Add(*world, floor), crate = Add(*world, sliding);
    Steps(*world, 15);
    for (EntityDesc* of : {&floor, &sliding}) of->rigid_body->geometries[0].material.friction = kRough;
    for (const bool of_floor : {is_floor, !is_floor}) {
      Do(*world, UpdateEntity{.id = of_floor ? ground : crate,
                              .entity = of_floor ? floor : sliding,
                              .fields = {static_cast<uint32_t>(EntityField::kGeometries)}});
    }
    Steps(*world, 15);
    const double before = kFriction * kGravity, after = kRough * kGravity;
    const double left = kSpeed - before * kTime;
    EXPECT_NEAR(VelocityOf(*world, crate).x(), left - after * kTime, kSwept * kSpeed) << is_floor;
    EXPECT_NEAR(PositionOf(*world, crate).x(),
                kSpeed * kTime - before * kTime * kTime / 2 + left * kTime - after * kTime * kTime / 2, kSwept)
        << is_floor;
  }
}

TEST_P(HeldOtherwise, AMotorThatTurnsRoundPushesTheOtherWayAtOnce) {
  Proves({Claim::kJointSlider, Claim::kJointMotor, Claim::kJointChange});
  constexpr double kForce = 8, kTime = 0.5;
  const JointAxis driven{.limits = {}, .motor = Motor{.target_velocity = 1000, .force_max = kForce}, .spring = {}};
  enum class How { kTurned, kTaken };
  for (const How how : {How::kTurned, How::kTaken}) {
    const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
    const EntityId ball = Add(*world, Ball({0, 0, 0}));
    const JointId joint = Join(*world, ToWorld(ball, SliderJoint{driven}));
    Steps(*world, 30);
    if (how == How::kTurned) {
      Do(*world, SetMotorColumns{.ids = {joint}, .velocities = {-1000}, .positions = {}});
    } else {
      Do(*world, UpdateJoint{.id = joint,
                             .joint = ToWorld(ball, SliderJoint{}),
                             .fields = {static_cast<uint32_t>(JointField::kMotor)}});
    }
    Steps(*world, 30);
    const double after = how == How::kTurned ? -kForce : 0, speed = kForce * kTime;
    EXPECT_NEAR(VelocityOf(*world, ball).z(), speed + after * kTime, kDirect * speed);
    EXPECT_NEAR(PositionOf(*world, ball).z(), kForce * kTime * kTime / 2 + speed * kTime + after * kTime * kTime / 2,
                kDirect * speed);
  }
}

TEST_P(HeldOtherwise, WhoseAxesAreUnlockedGoesAtOnce) {
  Proves({Claim::kLockedAxes, Claim::kKineticFriction, Claim::kLiveChange});
  constexpr double kPull = 5, kTime = 0.5;
  WorldDesc desc{.engine = GetParam(), .gravity = {kPull, 0, -kGravity}, .stepper = {.step_size = kStep}};
  desc.default_material.friction = kFriction;
  desc.default_auto_disable.enabled = false;
  const auto world = testing::MakeWorld(desc);
  EntityDesc box = Body(Box{{0.5, 0.5, 0.1}}, {0, 0, 0.1});
  box.rigid_body->locked_axes.linear = {true, false, false};
  const EntityId id = Add(*world, box);
  Steps(*world, 30);
  EXPECT_NEAR(PositionOf(*world, id).x(), 0, kTouch);
  box.rigid_body->locked_axes = {};
  Do(*world, UpdateEntity{.id = id, .entity = box, .fields = {static_cast<uint32_t>(EntityField::kLockedAxes)}});
  Steps(*world, 30);
  EXPECT_NEAR(PositionOf(*world, id).x(), (kPull - kFriction * kGravity) * kTime * kTime / 2, kAtOnce);
}

}  // namespace
}  // namespace genphys::testing

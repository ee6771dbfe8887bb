// A kinematic pusher moves as told, and what it pushes moves with it.
#include <cmath>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Pushing, Claim::kKinematicPush);

constexpr double kGravity = 9.81;
// Per metre of being pushed, along and across; promised.
constexpr double kOffAside = 5e-3;
constexpr double kOff = 1e-3;

struct Pushed {
  double mass = 1, heading = 0, friction = 0.5, speed = 1;
  Shape shape = Box{{0.5, 0.5, 0.5}};
  double front = 0.5, height = 0.5;  // of its origin: to the pusher, over the floor, m
  Shape pusher = Box{{0.1, 1, 0.5}};
  double thickness = 0.1;
};

Vector3 Along(double heading) { return {std::cos(heading), std::sin(heading), 0}; }

// How far it is moved in a second, along the push and across it.
Eigen::Vector2d MovedBy(const std::string& engine, const Pushed& pushed) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}};
  desc.default_material.friction = pushed.friction;
  const auto world = MakeWorld(desc);
  const Vector3 along = Along(pushed.heading), start(0.4, -0.7, pushed.height);
  const Quaternion turn(Eigen::AngleAxisd(pushed.heading, Vector3::UnitZ()));
  EntityDesc box = Body(pushed.shape, start, pushed.mass);
  box.pose.orientation = turn;
  EntityDesc pusher = Body(pushed.pusher, start - (pushed.front + pushed.thickness) * along);
  pusher.pose.position.z() = 0.55;
  pusher.pose.orientation = turn;
  pusher.rigid_body->motion_type = MotionType::kKinematic;
  pusher.rigid_body->linear_velocity = pushed.speed * along;
  const EntityId id = Add(*world, box);
  Add(*world, pusher);
  Steps(*world, 60);
  const Vector3 moved = PositionOf(*world, id) - start;
  const std::vector<TouchingPair> touching = TouchingIn(*world);
  const bool touches = std::any_of(touching.begin(), touching.end(),
                                   [&](const TouchingPair& pair) { return pair.pair.b != id && pair.pair.a == id; });
  EXPECT_TRUE(touches) << "it is still being pushed";
  return {moved.dot(along), moved.dot(Vector3::UnitZ().cross(along))};
}

TEST_P(Pushing, ABoxGoesAMetreInASecondAtOneMetrePerSecond) {
  const Eigen::Vector2d moved = MovedBy(GetParam(), {});
  EXPECT_NEAR(moved.x(), 1, kOff);
  EXPECT_NEAR(moved.y(), 0, kOff);
}

TEST_P(Pushing, WhateverItsMassHeadingAndFriction) {
  Random random(31);
  for (int i = 0; i < 8; ++i) {
    const Pushed pushed{.mass = random.LogUniform(1e-2, 1e3),
                        .heading = random.Uniform(-3, 3),
                        .friction = random.Uniform(0, 1),
                        .speed = random.Uniform(0.5, 1.5)};
    const Eigen::Vector2d moved = MovedBy(GetParam(), pushed);
    SCOPED_TRACE(::testing::Message() << "mass " << pushed.mass << " friction " << pushed.friction);
    EXPECT_NEAR(moved.x(), pushed.speed, kOff * pushed.speed);
    EXPECT_NEAR(moved.y(), 0, kOff * pushed.speed);
  }
}

TEST_P(Pushing, WhateverItsShapeAndThatOfThePusher) {
  const Shape wall = Box{{0.1, 1, 0.5}};
  for (const Pushed& pushed : {Pushed{.shape = HullBox({0.4, 0.6, 0.3}), .front = 0.4, .height = 0.3, .pusher = wall},
                               Pushed{.shape = Cylinder{0.5, 0.4}, .front = 0.5, .height = 0.4, .pusher = wall},
                               Pushed{.shape = Box{{0.4, 0.5, 0.5}},
                               .front = 0.4,
                               .height = 0.5,
                               .pusher = HullBox({0.2, 1, 0.5}),
                               .thickness = 0.2},
                               Pushed{.shape = Box{{0.4, 0.5, 0.5}},
                               .front = 0.4,
                               .height = 0.5,
                               .pusher = BoxMesh({0.2, 1, 0.5}),
                               .thickness = 0.2}}) {
    const Eigen::Vector2d moved = MovedBy(GetParam(), pushed);
    SCOPED_TRACE(::testing::Message() << "shape " << pushed.shape.index() << " by " << pushed.pusher.index());
    EXPECT_NEAR(moved.x(), 1, kOff);
    // Which of the points that stick to the pusher bears what is not determined, and the floor holds nothing that
    // slides. Measured on ODE for the cylinder: 4.2e-3.
    EXPECT_NEAR(moved.y(), 0, kOffAside);
  }
}

// How far (rad) a crate on three feet turns that a finger pushes beside its middle, 0.15 m far.
double TurnedByFinger(const std::string& engine, double speed, double heading, double rate) {
  constexpr double kBeside = 0.05, kFinger = 0.05, kFoot = 0.02;
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = 1 / rate}};
  desc.default_material.friction = 0.4;
  desc.default_auto_disable.enabled = false;
  desc.ground_plane = true;
  const auto world = MakeWorld(desc);
  const Quaternion turn(Eigen::AngleAxisd(heading, Vector3::UnitZ()));
  EntityDesc crate = Body(Box{{0.2, 0.2, 0.08}}, {0, 0, 0.1}, 1);
  crate.pose.orientation = turn;
  for (const Vector3& foot : {Vector3(0.18, 0, -0.08), Vector3(-0.15, 0.17, -0.08), Vector3(-0.15, -0.17, -0.08)}) {
    crate.rigid_body->geometries.push_back({.shape = Sphere{kFoot}, .pose_in_entity = {foot}});
  }
  for (Geometry& geometry : crate.rigid_body->geometries) geometry.material.friction = 0.4;
  crate.rigid_body->inertia = {.center_of_mass = Vector3(0, 0, 0), .tensor = Vector3(0.015, 0.015, 0.02).asDiagonal()};
  crate.rigid_body->inertia.mass = 1;
  EntityDesc finger = Body(Sphere{kFinger}, turn * Vector3(-0.2 - kFinger - 1e-4, kBeside, 0.1));
  finger.rigid_body->geometries[0].material.friction = 0.3;
  finger.rigid_body->motion_type = MotionType::kKinematic;
  finger.rigid_body->linear_velocity = turn * Vector3(speed, 0, 0);
  const EntityId id = Add(*world, crate);
  Add(*world, finger);
  Steps(*world, static_cast<int>(std::lround(0.15 / speed * rate)));
  const Quaternion turned = world->state().pose(EntityRow{id.index()}).orientation * turn.conjugate();
  return 2 * std::atan2(turned.z(), turned.w());
}

// Gravity would let it slip down along the finger, and nothing before the solve shows the way in which it does slip.
TEST_P(Pushing, AFingerThatHoldsTurnsWhatItPushesAsWithSmallSteps) {
  Proves({Claim::kBox, Claim::kSphere});
  // With 4,000 steps per second.
  for (const auto& [speed, turned] : {std::pair(0.05, -0.1154), std::pair(0.2, -0.1150), std::pair(1.0, -0.1176)}) {
    for (const double heading : {0.4, -1.1}) {
      EXPECT_NEAR(TurnedByFinger(GetParam(), speed, heading, 60), turned, 1e-3) << speed << " " << heading;
    }
  }
}

TEST_P(Pushing, WhatStandsOnAMovingFloorIsCarriedAlong) {
  Proves({Claim::kStaticFriction});
  Random random(32);
  for (int i = 0; i < 4; ++i) {
    const double heading = random.Uniform(-3, 3), speed = random.Uniform(0.5, 2);
    const auto world = MakeWorld();
    EntityDesc floor = Body(Box{{4, 4, 0.1}}, {0, 0, 1});
    floor.rigid_body->motion_type = MotionType::kKinematic;
    floor.rigid_body->linear_velocity = speed * Along(heading);
    Add(*world, floor);
    EntityDesc crate = Crate({0.3, 0.2, 1.4}, 0.3, random.LogUniform(1e-2, 1e3));
    crate.rigid_body->linear_velocity = speed * Along(heading);
    const EntityId rides = Add(*world, crate);
    crate.pose.position = {-2, 0.2, 1.4};
    crate.rigid_body->linear_velocity = Vector3::Zero();
    const EntityId boards = Add(*world, crate);
    Steps(*world, 60);
    EXPECT_LE((PositionOf(*world, rides) - Vector3(0.3, 0.2, 1.4) - speed * Along(heading)).norm(), kOff * speed);
    // It slides until it is as fast: v / (mu g), in which it falls behind by v^2 / (2 mu g).
    const double lost = speed * speed / (2 * 0.5 * kGravity);
    const Vector3 expected = Vector3(-2, 0.2, 1.4) + (speed - lost) * Along(heading);
    EXPECT_LE((PositionOf(*world, boards) - expected).norm(), 2 * StopError(0.5 * kGravity, SubstepOf(*world)) + kTouch)
        << "heading " << heading;
  }
}

TEST_P(Pushing, APusherMovesExactlyAsTold) {
  const auto world = MakeWorld();
  EntityDesc pusher = Crate({-2, 0, 0.6});
  pusher.rigid_body->motion_type = MotionType::kKinematic;
  pusher.rigid_body->linear_velocity = {1, 0.5, 0};
  pusher.rigid_body->angular_velocity = {0, 0, 0.3};
  const EntityId id = Add(*world, pusher);
  Add(*world, Crate({0, 0, 0.5}, 0.5, 1e3));  // however much is in its way
  Steps(*world, 180);
  EXPECT_LE((PositionOf(*world, id) - Vector3(1, 1.5, 0.6)).norm(), kRounded);
  const Quaternion turned(Eigen::AngleAxisd(0.9, Vector3::UnitZ()));
  EXPECT_LE(FromColumn(world->state().orientations.col(id.index())).angularDistance(turned), kRounded);
  EXPECT_EQ(VelocityOf(*world, id), Vector3(1, 0.5, 0));
}

EntityId AddLift(World& world, const Vector3& position) {
  EntityDesc lift = Body(Box{{0.1, 1, 0.5}}, position);
  lift.rigid_body->motion_type = MotionType::kKinematic;
  return Add(world, lift);
}

double AngleTo(const World& world, EntityId id, const Quaternion& orientation) {
  return FromColumn(world.state().orientations.col(id.index())).angularDistance(orientation);
}

TEST_P(Pushing, APusherThatIsLedStepByStepPushesAtItsSpeed) {
  Proves({Claim::kKinematicLed});
  for (const double speed : {0.3, 1.0, 2.0}) {
    const auto world = MakeWorld();
    const EntityId box = Add(*world, Crate({0, 0, 0.5}));
    const EntityId pusher = AddLift(*world, {-0.6, 0, 0.55});
    for (int i = 1; i <= 60; ++i) {
      Do(*world, SetPose{.id = pusher, .position = Vector3(-0.6 + speed * i / 60, 0, 0.55), .over_steps = 1});
      Steps(*world, 1);
      EXPECT_NEAR(VelocityOf(*world, pusher).x(), speed, kRounded * 60);
    }
    EXPECT_NEAR(PositionOf(*world, box).x(), speed, kOff * speed);
  }
}

TEST_P(Pushing, AFastThinPusherPassesThroughNobodyAsleepOrAwake) {
  Proves({Claim::kKinematicLed, Claim::kRestitution});
  Random random(7);
  for (int i = 0; i < 24; ++i) {
    const double speed = random.LogUniform(5, 200);
    const bool is_led = i % 2 == 0, sleeps = i % 4 < 2;
    WorldDesc desc{.engine = GetParam(), .gravity = Vector3::Zero(), .ground_plane = false};
    desc.default_material.restitution = 1;
    const auto world = testing::MakeWorld(desc);
    Require(*world, Feature::kContacts);
    const EntityId ball = Add(*world, Ball({0, 0, 0}, 0.03));
    // Some are much wider than they go in a step.
    const double half_width = i % 3 == 0 ? 3 : 0.2;
    EntityDesc paddle = Body(Box{{0.01, half_width, half_width}}, {-1 - random.Uniform(0, 1), 0, 0});
    paddle.rigid_body->motion_type = MotionType::kKinematic;
    const EntityId id = Add(*world, paddle);
    if (sleeps) {
      Steps(*world, 60);
      ASSERT_TRUE(Asleep(*world, ball));
    }
    const auto steps = static_cast<uint32_t>(std::ceil(4 / speed * 60));
    const Vector3 way = Vector3(speed * steps / 60, 0, 0);
    if (is_led) {
      Do(*world, SetPose{.id = id, .position = Vector3(paddle.pose.position + way), .over_steps = steps});
    } else {
      Do(*world, SetVelocity{id, Vector3(speed, 0, 0), Vector3(Vector3::Zero())});
    }
    Steps(*world, static_cast<int>(steps));
    // Elastic, off something that goes on as it does.
    EXPECT_NEAR(VelocityOf(*world, ball).x(), 2 * speed, 1e-6 * speed) << "case " << i << " at " << speed << " m/s";
  }
}

TEST_P(Pushing, WhatIsLedArrivesWhateverTheStepsAndStands) {
  Proves({Claim::kKinematicLed});
  Random random(33);
  const auto world = MakeWorld();
  const Vector3 target(1.5, -2, 3);
  const Quaternion turn(Eigen::AngleAxisd(2.5, Vector3(1, -2, 0.5).normalized()));
  const EntityId id = AddLift(*world, {-2, 0, 1});
  Do(*world, SetPose{.id = id, .position = target, .orientation = turn, .over_steps = 40});
  for (int i = 0; i < 40; ++i) {
    EXPECT_GT((PositionOf(*world, id) - target).norm(), 0.01) << "evenly, not at once";
    ASSERT_TRUE(world->Step(random.LogUniform(1e-3, 1e-1)).ok());
  }
  EXPECT_LE((PositionOf(*world, id) - target).norm(), kRounded);
  EXPECT_LE(AngleTo(*world, id, turn), kRounded);
  EXPECT_GT(VelocityOf(*world, id).norm(), 0) << "as fast as it came in the step that is over";
  Steps(*world, 1);
  EXPECT_EQ(VelocityOf(*world, id), Vector3(0, 0, 0));
  EXPECT_EQ(SpinOf(*world, id), Vector3(0, 0, 0));
  Steps(*world, 10);
  EXPECT_LE((PositionOf(*world, id) - target).norm(), kRounded);
}

TEST_P(Pushing, WhatIsLedObeysALaterCommand) {
  Proves({Claim::kKinematicLed});
  const auto world = MakeWorld();
  const SetPose away{.position = Vector3(10, 0, 1), .over_steps = 100};
  const auto lead = [&] {
    SetPose command = away;
    command.id = AddLift(*world, {0, 0, 1});
    Do(*world, command);
    Steps(*world, 10);
    EXPECT_NEAR(PositionOf(*world, command.id).x(), 1, kRounded);
    return command.id;
  };
  const EntityId steered = lead();
  Do(*world, SetVelocity{steered, Vector3(0, 1, 0), {}});
  Steps(*world, 60);
  EXPECT_LE((PositionOf(*world, steered) - Vector3(1, 1, 1)).norm(), kRounded);
  Do(*world, DeleteEntity{steered});

  const EntityId put = lead();
  Do(*world, SetPose{.id = put, .position = Vector3(5, 5, 5)});
  Steps(*world, 60);
  EXPECT_EQ(PositionOf(*world, put), Vector3(5, 5, 5)) << "it has no velocity of its own";
  Do(*world, DeleteEntity{put});

  const EntityId freed = lead();
  EntityDesc body = *world->Describe(freed);
  body.rigid_body->motion_type = MotionType::kDynamic;
  const double speed = VelocityOf(*world, freed).x();
  EXPECT_NEAR(speed, 0.1 * 60, 6 * kRounded);
  Do(*world, UpdateEntity{freed, body, {static_cast<uint32_t>(EntityField::kMotionType)}});
  EXPECT_EQ(VelocityOf(*world, freed).x(), speed) << "what is let go of flies on";
  Steps(*world, 10);
  EXPECT_NEAR(PositionOf(*world, freed).x(), 2, 2 * kRounded);
}

TEST_P(Pushing, WhatIsLedArrivesOnAnotherEngineToo) {
  Proves({Claim::kKinematicLed, Claim::kEngineChange});
  const auto world = MakeWorld();
  const EntityId id = AddLift(*world, {0, 0, 1});
  Do(*world, SetPose{.id = id, .position = Vector3(1, 0, 1), .over_steps = 20});
  Steps(*world, 5);
  Do(*world, SetEngine{"none"});
  Steps(*world, 5);
  EXPECT_NEAR(PositionOf(*world, id).x(), 0.25, kRounded) << "without an engine nothing moves";
  Do(*world, SetEngine{OtherEngine(GetParam())});
  Steps(*world, 15);
  EXPECT_NEAR(PositionOf(*world, id).x(), 1, kRounded);
}

TEST_P(Pushing, OnlyKinematicBodiesAreLed) {
  Proves({Claim::kKinematicLed});
  const auto world = MakeWorld();
  for (const EntityId id : {Add(*world, Ball({0, 0, 3})), Add(*world, Block({5, 0, 1}, {1, 1, 1}))}) {
    const Command lead = SetPose{.id = id, .position = Vector3(1, 0, 3), .over_steps = 1};
    const auto refused = world->Apply({&lead, 1});
    const std::optional<Refusal> refusal = RefusalOf(refused.status());
    ASSERT_TRUE(refusal);
    EXPECT_EQ(refusal->field, "commands[0].set_pose.over_steps");
    Do(*world, SetPose{.id = id, .position = Vector3(1, 0, 3)});
  }
}

// What a command moves through what a joint holds cannot be solved, for neither can give way; but it must end nothing.
TEST_P(Pushing, WhatAJointHoldsIsThereAgainAfterwards) {
  Proves({Claim::kJointHinge});
  Random random(5);
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(i);
    const auto world = MakeSpace(GetParam());
    const EntityId bar = Add(*world, Body(Capsule{0.1, 0.4}, Vector3::Zero(), 0.4));
    const Vector3 way = random.Direction();
    EntityDesc pusher = Body(Cone{0.3, 0.4}, 0.1 * random.Direction() - 0.9 * way);
    pusher.pose.orientation = random.Turn();
    pusher.rigid_body->motion_type = MotionType::kKinematic;
    pusher.rigid_body->linear_velocity = 2 * way;
    const EntityId pushing = Add(*world, pusher);
    const Vector3 end(0, 0, -0.4);
    const JointId hinge = Join(*world, ToWorld(bar, HingeJoint{}, FrameAlong(random.Direction(), end)));
    Steps(*world, 60);
    Do(*world, DeleteEntity{pushing});
    Steps(*world, 60);
    EXPECT_TRUE(Of<EntityFaulted>(world->TakeEvents()).empty());
    // The middle goes round the hinge's axis, at v / w from it.
    const double speed = VelocityOf(*world, bar).norm(), radius = speed / SpinOf(*world, bar).norm();
    EXPECT_LE(GapOf(*world, hinge), 2 * OffCircle(speed, SubstepOf(*world), radius) + kDirect * end.norm());
  }
}

TEST_P(Pushing, AWayTooFastForTheLimitsIsDoneAtOnce) {
  Proves({Claim::kKinematicLed});
  const auto world = MakeWorld();
  const EntityId id = AddLift(*world, {0, 0, 1});
  Do(*world, SetPose{.id = id, .position = Vector3(1e6, 0, 1), .over_steps = 1});
  Steps(*world, 1);
  EXPECT_EQ(PositionOf(*world, id), Vector3(1e6, 0, 1));
  EXPECT_EQ(VelocityOf(*world, id), Vector3(0, 0, 0));
}

}  // namespace
}  // namespace genphys::testing

// Rest costs nothing and ends in the step that something happens.
#include <algorithm>
#include <vector>

#include "conformance/engine_test.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Sleeping, Claim::kSleeping);

TEST_P(Sleeping, ARestingStackFallsAsleepAsOne) {
  Proves({Claim::kSleepEvents});
  const auto world = MakeWorld();
  const EntityId low = Add(*world, Crate({0, 0, 0.5})), high = Add(*world, Crate({0, 0, 1.5}));
  world->TakeEvents();

  Steps(*world, 120);

  EXPECT_TRUE(Asleep(*world, low));
  EXPECT_TRUE(Asleep(*world, high));
  const auto slept = Of<EntitySlept>(world->TakeEvents());
  ASSERT_EQ(slept.size(), 2u);
  EXPECT_EQ(slept[0].id, low);
  EXPECT_EQ(slept[1].id, high);
}

TEST_P(Sleeping, NothingChangesWhileAllSleep) {
  const auto world = MakeWorld();
  Add(*world, Crate({0, 0, 0.5}));
  Steps(*world, 120);
  const StateArrays before = world->state();
  world->TakeEvents();

  Steps(*world, 100);

  EXPECT_EQ(world->state().positions, before.positions);
  EXPECT_TRUE(world->TakeEvents().empty());
}

TEST_P(Sleeping, StepsOfAWorldAtRestNeedOnlyBeCounted) {
  Proves({Claim::kKinematicLed});
  const auto stepped = MakeWorld(), counted = MakeWorld();
  EntityId ball;
  for (World* world : {stepped.get(), counted.get()}) {
    ball = Add(*world, Ball({0, 0, 0.5}));
    EXPECT_FALSE(world->IsAtRest());
    Steps(*world, 200);
    ASSERT_TRUE(Asleep(*world, ball) && world->IsAtRest());
  }
  Steps(*stepped, 12'345);
  counted->StepAtRest(12'345);
  EXPECT_EQ(counted->StateHash(), stepped->StateHash());
  Do(*counted, ApplyForce{.id = ball, .force = {0, 0, 1}});
  EXPECT_FALSE(counted->IsAtRest());

  EntityDesc lift = Ball({5, 0, 5});
  lift.rigid_body->motion_type = MotionType::kKinematic;
  const EntityId led = Add(*stepped, lift);
  Steps(*stepped, 200);
  EXPECT_TRUE(stepped->IsAtRest()) << "it stands still";
  Do(*stepped, SetPose{.id = led, .position = Vector3(5, 0, 5), .over_steps = 3});
  EXPECT_FALSE(stepped->IsAtRest()) << "it is on its way";
}

TEST_P(Sleeping, ABodyThatMayNotSleepStaysAwake) {
  const auto world = MakeWorld();
  EntityDesc crate = Crate({0, 0, 0.5});
  crate.rigid_body->auto_disable.enabled = false;
  const EntityId id = Add(*world, crate);

  Steps(*world, 300);

  EXPECT_FALSE(Asleep(*world, id));
}

TEST_P(Sleeping, WithoutARestTimeABodySleepsOnceItRestsAndNotBefore) {
  WorldDesc desc{.engine = GetParam(), .ground_plane = true};
  desc.default_auto_disable.rest_time = 0;
  const auto world = testing::MakeWorld(desc);
  const EntityId lying = Add(*world, Crate({5, 0, 0.5})), falling = Add(*world, Crate({0, 0, 3}));

  Steps(*world, 3);
  EXPECT_TRUE(Asleep(*world, lying));
  EXPECT_FALSE(Asleep(*world, falling));

  Steps(*world, 60);
  EXPECT_TRUE(Asleep(*world, falling));
  EXPECT_NEAR(PositionOf(*world, falling).z(), 0.5, 1e-3);
}

TEST_P(Sleeping, ALargePileThatTremblesFallsAsleep) {
  Proves({Claim::kContacts});
  // Layers in disorder, so that they make a pile and no columns; of so many contacts few are swept at rest. In one
  // of them a box may still roll after 11 s.
  int piles_asleep = 0;
  for (const uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    WorldDesc desc{.engine = GetParam()};
    desc.default_material.friction = 0.5;
    const auto world = testing::MakeWorld(desc);
    Random random(seed);
    constexpr int kRow = 5, kLayers = 4;
    std::vector<EntityId> boxes;
    for (int i = 0; i < kRow * kRow * kLayers; ++i) {
      const int layer = i / (kRow * kRow);
      const double aside = layer % 2 == 0 ? -0.3 : 0.3;
      EntityDesc crate = Crate({1.3 * (i % kRow) + aside, 1.3 * (i / kRow % kRow) + aside, 0.6 + 1.1 * layer});
      crate.pose.orientation = Quaternion(Eigen::AngleAxisd(random.Uniform(-0.3, 0.3), Vector3::UnitZ()));
      boxes.push_back(Add(*world, crate));
    }
    Steps(*world, 11 * 60);
    piles_asleep += std::ranges::all_of(boxes, [&](EntityId id) { return Asleep(*world, id); });
  }
  EXPECT_GE(piles_asleep, 5);
}

TEST_P(Sleeping, WhatGoesSlowlyButGetsSomewhereStaysAwake) {
  Proves({Claim::kContacts});
  // On a smooth floor, each at half as much again as what rests at most; and one that is slow enough.
  const auto world = MakeWorld();
  const auto add = [&](double y, double speed, double spin) {
    EntityDesc crate = Crate({0, y, 0.5});
    crate.rigid_body->geometries[0].material = {.friction = 0};
    crate.rigid_body->linear_velocity = {speed, 0, 0};
    crate.rigid_body->angular_velocity = {0, 0, spin};
    return Add(*world, crate);
  };
  const EntityId sliding = add(0, 0.03, 0), turning = add(3, 0, 0.075), slow = add(6, 0.015, 0.03);
  Steps(*world, 300);
  EXPECT_FALSE(Asleep(*world, sliding));
  EXPECT_FALSE(Asleep(*world, turning));
  EXPECT_TRUE(Asleep(*world, slow));
  EXPECT_NEAR(PositionOf(*world, sliding).x(), 0.15, 1e-6);
}

TEST_P(Sleeping, WhatHopsOrSwingsStaysAwakeHoweverLittle) {
  Proves({Claim::kContacts, Claim::kRestitution, Claim::kSpringField});
  // Hops of 0.6 mm at up to 0.025 m/s.
  WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -0.5}, .ground_plane = true};
  desc.default_material = {.friction = 0, .restitution = 1};
  const auto world = testing::MakeWorld(desc);
  const EntityId hopping = Add(*world, Ball({0, 0, 0.5 + 6.25e-4}));
  // To and fro by 2 mm at up to 0.05 m/s, on nothing.
  EntityDesc mass = Ball({5, 0, 5});
  mass.rigid_body->gravity_scale = 0;
  mass.rigid_body->linear_velocity = {0.05, 0, 0};
  const EntityId swinging = Add(*world, mass);
  Do(*world, CreateForceField{{.kind = SpringField{.a = swinging, .point_in_b = {5, 0, 5}, .stiffness = 625}}});
  for (int i = 0; i < 300; ++i) {
    Steps(*world, 1);
    ASSERT_FALSE(Asleep(*world, hopping)) << "step " << i;
    ASSERT_FALSE(Asleep(*world, swinging)) << "step " << i;
  }
}

TEST_P(Sleeping, WhoTurnsRoundInTheAirOrIsPushedGentlyStaysAwake) {
  Proves({Claim::kForce});
  for (const double rest_time : {0.0, 0.5}) {
    WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -9.81}, .ground_plane = false};
    desc.default_auto_disable.rest_time = rest_time;
    desc.stepper.step_size = 1.0 / 1000;
    const auto world = testing::MakeWorld(desc);
    EntityDesc ball = Ball({0, 0, 0});
    ball.rigid_body->linear_velocity = {0, 0, 1};
    const EntityId thrown = Add(*world, ball);
    EntityDesc weightless = Ball({5, 0, 0});
    weightless.rigid_body->gravity_scale = 0;
    const EntityId pushed = Add(*world, weightless);
    Do(*world, ApplyForce{.id = pushed, .force = {0.01, 0, 0}, .steps = 3000});
    weightless.pose.position.x() = 10;
    const EntityId still = Add(*world, weightless);

    for (int i = 0; i < 3000; ++i) {
      Steps(*world, 1);
      ASSERT_FALSE(Asleep(*world, thrown) || Asleep(*world, pushed)) << "step " << i;
    }
    EXPECT_NEAR(PositionOf(*world, pushed).x(), 5 + 0.01 * 9 / 2, 1e-9);
    EXPECT_TRUE(Asleep(*world, still));
  }
}

TEST_P(Sleeping, AHitWakesTheWholeIslandAndEndsNoContact) {
  const auto world = MakeWorld();
  const EntityId low = Add(*world, Crate({0, 0, 0.5})), high = Add(*world, Crate({0, 0, 1.5}));
  Steps(*world, 120);
  ASSERT_TRUE(Asleep(*world, low) && Asleep(*world, high));
  const EntityId ball = Add(*world, Ball({0, 0, 3}));
  world->TakeEvents();

  uint64_t met = 0, woke = 0;
  for (int i = 0; i < 60; ++i) {
    Steps(*world, 1);
    const std::vector<Event> events = world->TakeEvents();
    EXPECT_TRUE(Of<ContactEnded>(events).empty());
    for (const ContactBegan& began : Of<ContactBegan>(events)) {
      EXPECT_EQ(began.pair, (EntityPair{high, ball})) << "resting contacts are not told again";
      met = world->layer_state().step;
    }
    if (Of<EntityWoke>(events).size() == 2) woke = world->layer_state().step;
  }
  EXPECT_GT(met, 0u);
  EXPECT_EQ(woke, met);
}

TEST_P(Sleeping, WhoWakesIsTiedToWhoIsWokenByContactsJointsOrSprings) {
  const auto world = MakeWorld();
  Require(*world, Feature::kJointBall);
  // Two stand on each other, a joint ties the third, a spring the fourth; two more share the floor only.
  const EntityId low = Add(*world, Crate({0, 0, 0.5})), high = Add(*world, Crate({0, 0, 1.5}));
  const EntityId joined = Add(*world, Crate({3, 0, 0.5})), sprung = Add(*world, Crate({6, 0, 0.5}));
  const EntityId near = Add(*world, Crate({0, 3, 0.5})), far = Add(*world, Crate({0, 30, 0.5}));
  JointDesc joint;
  joint.kind = BallJoint{};
  joint.entity_a.id = high;
  joint.entity_b.id = joined;
  joint.frame_in_a = Pose{.position = {1.5, 0, -0.5}};
  joint.frame_in_b = Pose{.position = {-1.5, 0, 0.5}};
  Do(*world, CreateJoint{joint});
  ForceField spring;
  spring.kind = SpringField{.a = joined, .b = sprung, .rest_length = 3, .stiffness = 1};
  Do(*world, CreateForceField{spring});
  const std::vector<EntityId> all{low, high, joined, sprung, near, far}, island{low, high, joined, sprung};
  for (const EntityId woken : all) {
    Steps(*world, 200);
    for (const EntityId id : all) ASSERT_TRUE(Asleep(*world, id));
    // At once: a step would find the others by itself, one after the other.
    Do(*world, ApplyImpulse{.id = woken, .linear = {0, 0, 1e-3}});
    const bool is_tied = std::ranges::count(island, woken) > 0;
    for (const EntityId id : all) {
      const bool is_in_island = std::ranges::count(island, id) > 0;
      EXPECT_EQ(!Asleep(*world, id), id == woken || (is_tied && is_in_island));
    }
  }
}

TEST_P(Sleeping, ASleeperTakesAllOfABlow) {
  // Wherever within its step the other one reaches it: one of equal mass that bounces fully stops, and it goes on.
  for (int i = 0; i < 20; ++i) {
    const auto world = testing::MakeWorld({.engine = GetParam(), .gravity = Vector3::Zero(), .ground_plane = false});
    Require(*world, Feature::kContacts);
    EntityDesc moving = Ball({-4 + 0.005 * i, 0, 0}, 0.25), resting = Ball({0, 0, 0}, 0.25);
    moving.rigid_body->linear_velocity = {3, 0, 0};
    for (EntityDesc* ball : {&moving, &resting}) {
      ball->rigid_body->geometries[0].material = {.friction = 0, .restitution = 1};
    }
    const EntityId a = Add(*world, moving), b = Add(*world, resting);
    Steps(*world, 50);
    ASSERT_TRUE(Asleep(*world, b));
    Steps(*world, 50);
    EXPECT_NEAR(VelocityOf(*world, a).x(), 0, 3 * kRounded) << "case " << i;
    EXPECT_NEAR(VelocityOf(*world, b).x(), 3, 3 * kRounded) << "case " << i;
  }
}

TEST_P(Sleeping, WhoIsTouchedWakesInThatStepAndNotBefore) {
  Proves({Claim::kContactEvents});
  // Slowly and fast, wherever within its step and its substep the other one reaches it. They go on together, and what
  // was still asleep when the solver stopped the other one at it would have stopped it as a wall does.
  for (const double speed : {0.15, 0.5, 3.0}) {
    for (int i = 0; i < 20; ++i) {
      const auto world = MakeWorld();
      EntityDesc moving = Crate({-1 - (45 + 0.05 * i) * speed / 60, 0, 0.5}), resting = Crate({0, 0, 0.5});
      moving.rigid_body->linear_velocity = {speed, 0, 0};
      for (EntityDesc* crate : {&moving, &resting}) crate->rigid_body->geometries[0].material = {.friction = 0};
      Add(*world, moving);
      const EntityId b = Add(*world, resting);
      Steps(*world, 44);
      ASSERT_TRUE(Asleep(*world, b));
      world->TakeEvents();
      bool is_touched = false;
      for (int step = 44; step < 50 && !is_touched; ++step) {
        Steps(*world, 1);
        is_touched = !Of<ContactBegan>(world->TakeEvents()).empty();
        ASSERT_EQ(Asleep(*world, b), !is_touched) << speed << " m/s, case " << i;
      }
      EXPECT_TRUE(is_touched);
      Steps(*world, 1);  // what is shown in the one of the touch takes it for what goes on
      EXPECT_NEAR(VelocityOf(*world, b).x(), speed / 2, 1e-3 * speed) << speed << " m/s, case " << i;
    }
  }
}

TEST_P(Sleeping, ATowerWakesAsIfItHadBeenAwakeWhoeverMovedMeanwhile) {
  constexpr int kCount = 5;
  double fastest[2] = {};
  for (const bool sleeps : {false, true}) {
    WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -9.81}};
    desc.default_auto_disable = {.enabled = sleeps, .rest_time = 2};  // until sweeps have left hardly anything
    const auto world = testing::MakeWorld(desc);
    std::vector<EntityId> tower;
    for (int i = 0; i < kCount; ++i) tower.push_back(Add(*world, Crate({0, 0, 0.5 + i})));
    const EntityId other = Add(*world, Crate({50, 0, 0.5}));
    Steps(*world, 400);
    ASSERT_EQ(Asleep(*world, tower.back()), sleeps);
    Do(*world, ApplyForce{.id = other, .force = {3, 0, 0}});
    Steps(*world, 5);
    ASSERT_EQ(Asleep(*world, tower.front()), sleeps);
    Do(*world, ApplyForce{.id = tower.front(), .force = {0, 0, -1e-9}});
    for (int step = 0; step < 30; ++step) {
      Steps(*world, 1);
      for (const EntityId id : tower) fastest[sleeps] = std::max(fastest[sleeps], VelocityOf(*world, id).norm());
    }
    EXPECT_FALSE(Asleep(*world, tower.front()));
  }
  constexpr double kStill = 1e-6;  // m/s, of what sweeps leave in either
  EXPECT_LE(fastest[true], std::max(2 * fastest[false], kStill));
}

TEST_P(Sleeping, WhoIsLetGoInItsSleepGoesFromThenOnAsTheClosedFormSays) {
  constexpr double kTime = 0.5;
  const Vector3 down(0, 0, -9.81), up(0, 0, 30);
  struct Change {
    Command command;
    Vector3 acceleration;
  };
  const ForceField everywhere{.kind = UniformField{.acceleration = up}};
  ForceField inside = everywhere;
  inside.region = Region{{-9, -9, -9}, {9, 9, 20}};
  for (const int heights : {1, 2}) {
    for (int which = 0; which < 5; ++which) {
      WorldDesc desc{.engine = GetParam(), .gravity = down, .ground_plane = false};
      const auto world = testing::MakeWorld(desc);
      Require(*world, Feature::kContacts);
      const EntityId block = Add(*world, Block({0, 0, -0.5}, {2, 2, 0.5}));
      std::vector<EntityId> tower;
      for (int i = 0; i < heights; ++i) tower.push_back(Add(*world, Crate({0, 0, 0.5 + i})));
      Steps(*world, 120);
      ASSERT_TRUE(Asleep(*world, tower.back()));
      const std::vector<Change> changes{{CreateForceField{everywhere}, down + up},
                                        {CreateForceField{inside}, down + up},
                                        {SetGravity{Vector3(1, 0, 4)}, {1, 0, 4}},
                                        {SetGravity{Vector3(0, 0, 0)}, {0, 0, 0}},
                                        {DeleteEntity{block}, down}};
      Do(*world, changes[static_cast<size_t>(which)].command);
      Steps(*world, 30);
      for (int i = 0; i < heights; ++i) {
        const Vector3 went = kTime * kTime / 2 * changes[static_cast<size_t>(which)].acceleration;
        EXPECT_LT((PositionOf(*world, tower[static_cast<size_t>(i)]) - Vector3(0, 0, 0.5 + i) - went).norm(), 1e-5)
            << heights << " high, change " << which;
      }
    }
  }
}

TEST_P(Sleeping, NobodyWakesForTheGravityThatThereIs) {
  const auto world = MakeWorld();
  const EntityId ball = Add(*world, Ball({0, 0, 0.5}));
  Steps(*world, 120);
  ASSERT_TRUE(Asleep(*world, ball));
  const Vector3 gravity = world->scene().world.gravity;
  Do(*world, SetGravity{gravity});
  EXPECT_TRUE(Asleep(*world, ball));
  Do(*world, SetGravity{2 * gravity});
  EXPECT_FALSE(Asleep(*world, ball));
}

TEST_P(Sleeping, WhateverIsPutIntoASleeperWakesIt) {
  for (const MotionType motion : {MotionType::kStatic, MotionType::kKinematic}) {
    const auto world = MakeWorld();
    const EntityId ball = Add(*world, Ball({0, 0, 0.5}));
    Steps(*world, 120);
    ASSERT_TRUE(Asleep(*world, ball));
    EntityDesc wedge = Ball({0.6, 0, 0.5}, 0.5);
    wedge.rigid_body->motion_type = motion;
    Add(*world, wedge);
    // Overlaps are taken away at 0.3 m/s at least, and maybe a substep late.
    Steps(*world, 66);
    EXPECT_LT(PositionOf(*world, ball).x(), -0.3 * (66.0 / 60 - SubstepOf(*world))) << "it is pushed out of the way";
  }
}

TEST_P(Sleeping, NobodyWakesForWhatIsPutElsewhere) {
  for (const MotionType motion : {MotionType::kStatic, MotionType::kKinematic}) {
    const auto world = MakeWorld();
    const EntityId ball = Add(*world, Ball({0, 0, 0.5}));
    Steps(*world, 120);
    ASSERT_TRUE(Asleep(*world, ball));
    EntityDesc wedge = Ball({1.2, 0, 0.5}, 0.5);
    wedge.rigid_body->motion_type = motion;
    const EntityId put = Add(*world, wedge);
    EXPECT_TRUE(Asleep(*world, ball));
    Do(*world, SetPose{.id = put, .position = Vector3(-1.2, 0, 0.5)});
    EXPECT_TRUE(Asleep(*world, ball));
    Do(*world, SetPose{.id = put, .position = Vector3(-0.6, 0, 0.5)});
    EXPECT_FALSE(Asleep(*world, ball));
  }
}

TEST_P(Sleeping, AForceOrALostSupportWakes) {
  const auto world = MakeWorld();
  const EntityId low = Add(*world, Crate({0, 0, 0.5})), high = Add(*world, Crate({0, 0, 1.5}));
  const EntityId aside = Add(*world, Crate({5, 0, 0.5}));
  Steps(*world, 120);
  ASSERT_TRUE(Asleep(*world, high) && Asleep(*world, aside));

  Do(*world, ApplyForce{.id = aside, .force = {0, 0, 100}});
  EXPECT_FALSE(Asleep(*world, aside));
  EXPECT_TRUE(Asleep(*world, high));
  Do(*world, DeleteEntity{low});
  EXPECT_FALSE(Asleep(*world, high));

  Steps(*world, 120);
  EXPECT_NEAR(PositionOf(*world, high).z(), 0.5, kTouch);
}

TEST_P(Sleeping, AMovingLiftWakesWhatItTouches) {
  Proves({Claim::kKinematicPush});
  const auto world = MakeWorld();
  const EntityId crate = Add(*world, Crate({0, 0, 0.5}));
  EntityDesc pusher = Crate({-3, 0, 0.6});
  pusher.rigid_body->motion_type = MotionType::kKinematic;
  const EntityId lift = Add(*world, pusher);
  Steps(*world, 120);
  ASSERT_TRUE(Asleep(*world, crate));

  Do(*world, SetVelocity{.id = lift, .linear = Vector3(1, 0, 0)});
  Steps(*world, 180);

  // The faces were 2 m apart; 3 s at 1 m/s leave 1 m of pushing, which is promised to a millimetre.
  EXPECT_NEAR(PositionOf(*world, crate).x(), 1.0, 1e-3);
  EXPECT_FALSE(Asleep(*world, crate));
}

TEST_P(Sleeping, ABodyOnAMovingLiftDoesNotSleep) {
  const auto world = MakeWorld();
  EntityDesc platform = Body(Box{{2, 2, 0.1}}, {0, 0, 1});
  platform.rigid_body->motion_type = MotionType::kKinematic;
  platform.rigid_body->linear_velocity = {0, 0, 0.01};  // slower than the threshold of rest
  Add(*world, platform);
  const EntityId crate = Add(*world, Crate({0, 0, 1.6}));

  Steps(*world, 300);

  EXPECT_FALSE(Asleep(*world, crate));
  EXPECT_TRUE(Of<EntitySlept>(world->TakeEvents()).empty()) << "not even for a step";
  EXPECT_NEAR(PositionOf(*world, crate).z(), 1.6 + 0.05, kTouch);
}

TEST_P(Sleeping, ASleeperThatIsMadeAnotherIsToldToWakeOnce) {
  Proves({Claim::kSleepEvents, Claim::kLiveChange});
  for (const EntityField field : {EntityField::kInertia, EntityField::kGeometries, EntityField::kMotionType}) {
    const auto world = MakeWorld();
    EntityDesc desc = Crate({0, 0, 0.5});
    const EntityId crate = Add(*world, desc);
    Steps(*world, 120);
    ASSERT_TRUE(Asleep(*world, crate));
    world->TakeEvents();
    desc.rigid_body->inertia.mass = 2;
    desc.rigid_body->geometries[0].material.friction = 0.9;
    if (field == EntityField::kMotionType) desc.rigid_body->motion_type = MotionType::kKinematic;
    Do(*world, UpdateEntity{.id = crate, .entity = desc, .fields = {static_cast<uint32_t>(field)}});
    Steps(*world, 120);
    const std::vector<Event> events = world->TakeEvents();
    EXPECT_EQ(Of<EntityWoke>(events).size(), 1u) << static_cast<uint32_t>(field);
    EXPECT_EQ(Of<EntitySlept>(events).size(), field == EntityField::kMotionType ? 0u : 1u);
  }
}

TEST_P(Sleeping, WhatMovesAndIsMadeAnotherIsToldToMoveOnceAndToStopOnce) {
  Proves({Claim::kMotionEvents, Claim::kLiveChange});
  for (const EntityField field : {EntityField::kInertia, EntityField::kGeometries, EntityField::kMotionType}) {
    WorldDesc all{.engine = GetParam(), .gravity = Vector3::Zero()};
    all.ground_plane = false;
    all.recorded_events.moving = true;
    const auto world = testing::MakeWorld(all);
    EntityDesc desc = Ball({0, 0, 0});
    desc.rigid_body->linear_velocity = {1, 0, 0};
    desc.rigid_body->angular_velocity = {0, 0, 1};
    const EntityId ball = Add(*world, desc);
    Steps(*world, 10);
    desc.rigid_body->inertia.mass = 2;
    desc.rigid_body->geometries[0].material.friction = 0.9;
    if (field == EntityField::kMotionType) desc.rigid_body->motion_type = MotionType::kStatic;
    Do(*world, UpdateEntity{.id = ball, .entity = desc, .fields = {static_cast<uint32_t>(field)}});
    Steps(*world, 10);
    std::vector<Event> events = world->TakeEvents();
    EXPECT_EQ(Of<EntityStartedMoving>(events).size(), 2u);
    if (field != EntityField::kMotionType) {
      EXPECT_TRUE(Of<EntityStoppedMoving>(events).empty());
      Do(*world, SetVelocity{.id = ball, .linear = Vector3(0, 0, 0), .angular = Vector3(0, 0, 0)});
      Steps(*world, 1);
      events = world->TakeEvents();
    }
    EXPECT_EQ(Of<EntityStoppedMoving>(events).size(), 2u);
  }
}

}  // namespace
}  // namespace genphys::testing

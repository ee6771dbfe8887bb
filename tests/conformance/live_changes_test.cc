// What an entity is can change while the world runs: its body, its picture, each of its geometries, how it moves.
#include <cmath>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(LiveChanges, Claim::kLiveChange);

constexpr double kGravity = 9.81;
// Of numbers of some ten.
constexpr double kRounding = 10 * kRounded;

EntityDesc DescOf(const World& world, EntityId id) {
  const Result<EntityDesc> desc = world.Describe(id);
  EXPECT_TRUE(desc.ok()) << desc.status();
  return desc.ok() ? *desc : EntityDesc();
}

// Changes what the fields name to what `change` makes of the entity as it is.
template <typename Change>
void Update(World& world, EntityId id, std::initializer_list<EntityField> fields, Change change) {
  UpdateEntity update{.id = id, .entity = DescOf(world, id)};
  change(update.entity);
  for (const EntityField field : fields) update.fields.Add(field);
  Do(world, update);
}

void SetMotion(World& world, EntityId id, MotionType motion) {
  Update(world, id, {EntityField::kMotionType}, [&](EntityDesc& desc) { desc.rigid_body->motion_type = motion; });
}

bool Touches(const World& world, EntityId a, EntityId b) {
  const EntityPair pair{std::min(a, b), std::max(a, b)};
  const std::vector<TouchingPair> touching = TouchingIn(world);
  return std::any_of(touching.begin(), touching.end(), [&](const TouchingPair& t) { return t.pair == pair; });
}

TEST_P(LiveChanges, ABodyIsTakenAwayAndGivenBack) {
  Proves({Claim::kMotionTypes});
  const auto world = MakeWorld();
  const EntityId low = Add(*world, Crate({0, 0, 0.5})), high = Add(*world, Crate({0, 0, 1.5}, 0.5, 2));
  Steps(*world, 90);
  const RigidBody body = *DescOf(*world, low).rigid_body;

  Update(*world, low, {EntityField::kRigidBody}, [](EntityDesc& desc) { desc.rigid_body.reset(); });
  const Vector3 place = PositionOf(*world, low);
  Steps(*world, 90);

  EXPECT_NEAR(PositionOf(*world, high).z(), 0.5, kTouch) << "nothing is left below it";
  EXPECT_EQ(PositionOf(*world, low), place) << "it stays where it was put";
  EXPECT_FALSE(Touches(*world, low, high));

  Do(*world, SetPose{.id = low, .position = Vector3(0, 0, 1.6)});
  Update(*world, low, {EntityField::kRigidBody}, [&](EntityDesc& desc) { desc.rigid_body = body; });
  Steps(*world, 90);
  EXPECT_NEAR(PositionOf(*world, low).z(), 1.5, kTouch) << "it fell on the other one";
  EXPECT_TRUE(Touches(*world, low, high));
}

TEST_P(LiveChanges, AnEntityWithoutABodyGetsOneAndFalls) {
  Proves({Claim::kMotionTypes});
  const auto world = MakeWorld();
  EntityDesc sign;
  sign.pose.position = {0, 0, 5};
  const EntityId id = Add(*world, sign);
  Steps(*world, 30);
  EXPECT_EQ(PositionOf(*world, id), Vector3(0, 0, 5));

  Update(*world, id, {EntityField::kRigidBody}, [](EntityDesc& desc) { desc.rigid_body = Ball({0, 0, 0}).rigid_body; });
  Steps(*world, 30);

  EXPECT_NEAR(VelocityOf(*world, id).z(), -kGravity / 2, kRounding);
}

TEST_P(LiveChanges, APictureComesAndGoesWithoutATrace) {
  const auto world = MakeWorld(), same = MakeWorld();
  const auto scene = [](World& w) { return std::pair(Add(w, Crate({0, 0, 0.5})), Add(w, Ball({0.2, 0, 3}))); };
  const auto [crate, ball] = scene(*world);
  scene(*same);
  const Visual picture{"crate.glb", "model/gltf-binary", "bytes"};
  for (int i = 0; i < 60; ++i) {
    Steps(*world, 1), Steps(*same, 1);
    Update(*world, i % 2 == 0 ? crate : ball, {EntityField::kVisual},
           [&](EntityDesc& desc) { desc.visual = desc.visual ? std::nullopt : std::optional(picture); });
    EXPECT_EQ(DescOf(*world, crate).visual.has_value(), i % 4 < 2);
  }
  EXPECT_EQ(world->state().positions, same->state().positions);
  EXPECT_EQ(world->state().orientations, same->state().orientations);
}

TEST_P(LiveChanges, AGeometryIsAddedChangedAndRemoved) {
  const auto world = MakeWorld();
  const EntityId id = Add(*world, Body(Box{{0.5, 0.5, 0.2}}, {0, 0, 0.2}, 4));
  Steps(*world, 60);
  const auto change = [&](auto edit) {
    Update(*world, id, {EntityField::kGeometries}, [&](EntityDesc& desc) { edit(desc.rigid_body->geometries); });
    Steps(*world, 90);
    return PositionOf(*world, id).z();
  };

  // A foot below lifts it, a longer one more, and without it it is as before.
  EXPECT_NEAR(change([](std::vector<Geometry>& geometries) {
                geometries.push_back({.shape = Box{{0.4, 0.4, 0.1}}, .pose_in_entity = {{0, 0, -0.3}, {1, 0, 0, 0}}});
              }),
              0.4, kTouch);
  EXPECT_EQ(DescOf(*world, id).rigid_body->geometries[1].id, 2u);
  EXPECT_NEAR(
      change([](std::vector<Geometry>& geometries) {
        geometries[1] = {.id = 2, .shape = Box{{0.4, 0.4, 0.3}}, .pose_in_entity = {{0, 0, -0.5}, {1, 0, 0, 0}}};
      }),
      0.8, kTouch);
  EXPECT_NEAR(change([](std::vector<Geometry>& geometries) { geometries.pop_back(); }), 0.2, kTouch);
  EXPECT_EQ(world->scene().entities[id.index()]->mass.mass, 4);
  // Without any it falls through, being no less a body.
  EXPECT_LT(change([](std::vector<Geometry>& geometries) { geometries[0].collides_with_bits = 0; }), -5);
}

TEST_P(LiveChanges, AChangedMaterialIsFeltAtOnce) {
  const auto world = MakeWorld();
  Do(*world, SetGravity{{kGravity * 0.3, 0, -kGravity}});  // a slope that friction of 0.5 holds
  EntityDesc desc = Body(Box{{0.4, 0.4, 0.1}}, {0, 0, 0.1});
  const EntityId id = Add(*world, desc);
  Steps(*world, 60);
  const double held = PositionOf(*world, id).x();
  EXPECT_NEAR(held, 0, 2 * SweptSpeed(0.3 * kGravity, SubstepOf(*world)) * 1);

  Update(*world, id, {EntityField::kGeometries}, [](EntityDesc& now) {
    now.rigid_body->geometries[0].material.friction = 0;
    now.rigid_body->geometries[0].material.kinetic_friction = 0;
  });
  Steps(*world, 60);

  const double slides = 0.3 * kGravity / 2;
  EXPECT_NEAR(PositionOf(*world, id).x() - held, slides, kRounding) << "without friction";
}

TEST_P(LiveChanges, ADynamicEntityIsMadeStaticAndBack) {
  Proves({Claim::kMotionTypes});
  const auto world = MakeWorld();
  const EntityId low = Add(*world, Ball({0, 0, 3})), high = Add(*world, Ball({0, 0, 6}));
  Steps(*world, 20);
  SetMotion(*world, low, MotionType::kStatic);
  const Vector3 place = PositionOf(*world, low);
  EXPECT_EQ(VelocityOf(*world, low), Vector3::Zero());

  Steps(*world, 120);
  EXPECT_EQ(PositionOf(*world, low), place);
  // Balls that are exactly above each other balance, or roll off; either way the other one was stopped by it.
  EXPECT_LE(PositionOf(*world, high).z(), place.z() + 1 + kTouch);

  SetMotion(*world, low, MotionType::kDynamic);
  Steps(*world, 10);
  EXPECT_LT(PositionOf(*world, low).z(), place.z() - 1e-2) << "it falls again";
  Steps(*world, 180);
  EXPECT_NEAR(PositionOf(*world, low).z(), 0.5, kTouch);
}

TEST_P(LiveChanges, WhatLiesOnAnEntityThatIsMadeStaticLiesOn) {
  const auto world = MakeWorld();
  const EntityId low = Add(*world, Crate({0, 0, 0.5})), high = Add(*world, Crate({0, 0, 1.5}));
  for (const MotionType motion :
       {MotionType::kStatic, MotionType::kDynamic, MotionType::kKinematic, MotionType::kDynamic, MotionType::kStatic}) {
    Steps(*world, 60);
    SetMotion(*world, low, motion);
    Steps(*world, 60);
    EXPECT_NEAR(PositionOf(*world, high).z(), 1.5, 2 * kTouch);
    EXPECT_NEAR(PositionOf(*world, low).z(), 0.5, kTouch);
    EXPECT_TRUE(Touches(*world, low, high));
  }
}

TEST_P(LiveChanges, AKinematicEntityLetGoKeepsItsVelocity) {
  Proves({Claim::kMotionTypes});
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  EntityDesc desc = Crate({0, 0, 0});
  desc.rigid_body->motion_type = MotionType::kKinematic;
  desc.rigid_body->linear_velocity = {1, 2, 3};
  desc.rigid_body->angular_velocity = {0, 0, 1};
  const EntityId id = Add(*world, desc);
  Steps(*world, 30);
  SetMotion(*world, id, MotionType::kDynamic);
  EXPECT_EQ(VelocityOf(*world, id), Vector3(1, 2, 3));
  Steps(*world, 30);
  EXPECT_LE((PositionOf(*world, id) - Vector3(1, 2, 3)).norm(), kRounding);
  EXPECT_LE((SpinOf(*world, id) - Vector3(0, 0, 1)).norm(), kRounding);
}

// What is told of contacts and sensors in the next step.
struct TouchesTold {
  size_t begun = 0, ended = 0, persisted = 0, entered = 0, left = 0;
  bool operator==(const TouchesTold&) const = default;
};

TouchesTold NextOf(World& world) {
  Steps(world, 1);
  const std::vector<Event> events = world.TakeEvents();
  return {Of<ContactBegan>(events).size(), Of<ContactEnded>(events).size(), Of<ContactPersisted>(events).size(),
          Of<SensorEntered>(events).size(), Of<SensorLeft>(events).size()};
}

TEST_P(LiveChanges, WhoKeepsHisSurfacesGoesOnTouching) {
  Proves({Claim::kContactEvents, Claim::kSensors, Claim::kMotionTypes});
  WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -kGravity}};
  desc.recorded_events.persisting_contacts = true;
  const auto world = testing::MakeWorld(desc);
  EntityDesc gate = Crate({0, 0, 1}, 1);
  gate.rigid_body->motion_type = MotionType::kStatic;
  gate.rigid_body->geometries[0].is_sensor = true;
  Add(*world, gate);
  const EntityId low = Add(*world, Crate({0, 0, 0.5})), high = Add(*world, Crate({0, 0, 1.5}));
  Steps(*world, 20);
  world->TakeEvents();
  // Of the floor and the lower one, and of the two.
  const TouchesTold as_before{.persisted = 2};

  for (const EntityId id : {low, high}) {
    Update(*world, id, {EntityField::kInertia}, [](EntityDesc& now) { now.rigid_body->inertia.mass = 1.5; });
    EXPECT_EQ(NextOf(*world), as_before) << "another mass";
    Update(*world, id, {EntityField::kGeometries},
           [](EntityDesc& now) { now.rigid_body->geometries[0].material.friction = 0.3; });
    EXPECT_EQ(NextOf(*world), as_before) << "other friction";
    Update(*world, id, {EntityField::kErrorCorrection},
           [](EntityDesc& now) { now.rigid_body->error_correction.slop = 1e-4; });
    EXPECT_EQ(NextOf(*world), as_before) << "other error correction";
  }
  // It no longer touches the floor, which does not move either, but who lies on it does.
  SetMotion(*world, low, MotionType::kKinematic);
  EXPECT_EQ(NextOf(*world), (TouchesTold{.ended = 1, .persisted = 1}));

  Update(*world, high, {EntityField::kGeometries},
         [](EntityDesc& now) { now.rigid_body->geometries[0].shape = Box{Vector3::Constant(0.4)}; });
  const TouchesTold smaller = NextOf(*world);
  EXPECT_EQ(smaller.ended, 1u) << "it hangs above the other one";
  EXPECT_EQ(smaller.begun + smaller.persisted, 0u);
}

TEST_P(LiveChanges, AForceThatActsGoesOnWhileABodyIsReshaped) {
  Proves({Claim::kForce});
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  const EntityId id = Add(*world, Ball({0, 0, 0}, 0.5, 2));
  Do(*world, ApplyForce{.id = id, .force = {4, 0, 0}, .steps = 40});
  for (int i = 0; i < 6; ++i) {
    Steps(*world, 10);
    Update(*world, id, {EntityField::kGeometries},
           [&](EntityDesc& desc) { desc.rigid_body->geometries[0].shape = Sphere{0.3 + 0.1 * i}; });
  }
  EXPECT_NEAR(VelocityOf(*world, id).x(), 2 * 40 / 60.0, kRounding);
}

TEST_P(LiveChanges, ABodyThatWasReshapedInItsPlaceIsAsHardToTurnAsItIsNow) {
  Proves({Claim::kForce});
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  const EntityId id = Add(*world, Ball({0, 0, 0}, 0.5, 2));
  Join(*world, ToWorld(id, BallJoint{}));
  Steps(*world, 1);
  constexpr double kRadius = 0.25, kTorque = 1;
  Update(*world, id, {EntityField::kGeometries},
         [](EntityDesc& desc) { desc.rigid_body->geometries[0].shape = Sphere{kRadius}; });
  Do(*world, ApplyForce{.id = id, .torque = {0, 0, kTorque}});
  Steps(*world, 1);
  EXPECT_NEAR(SpinOf(*world, id).z(), kTorque / 60 / (0.4 * 2 * kRadius * kRadius), kRounding);
}

TEST_P(LiveChanges, AJointHoldsWhatIsReshapedAndStopped) {
  const auto world = MakeSpace(GetParam());
  const EntityId bob = Add(*world, Ball({1, 0, 0}, 0.2));
  const JointId hook = Join(*world, ToWorld(bob, BallJoint{}));
  Steps(*world, 20);
  Update(*world, bob, {EntityField::kGeometries},
         [](EntityDesc& desc) { desc.rigid_body->geometries[0].shape = Sphere{0.4}; });
  Steps(*world, 20);
  SetMotion(*world, bob, MotionType::kStatic);
  const Vector3 place = PositionOf(*world, bob);
  Steps(*world, 20);
  EXPECT_EQ(PositionOf(*world, bob), place);
  SetMotion(*world, bob, MotionType::kDynamic);
  Steps(*world, 60);
  EXPECT_EQ(world->joint_count(), 1u);
  EXPECT_LE(GapOf(*world, hook), 2 * OffCircle(std::sqrt(2 * kGravity), SubstepOf(*world), 1));
  EXPECT_GT((PositionOf(*world, bob) - place).norm(), 0.1) << "it swings on";
}

}  // namespace
}  // namespace genphys::testing

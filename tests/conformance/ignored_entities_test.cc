// Two entities of which one names the other as ignored never touch, whatever else they are told.
#include <cmath>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(IgnoredEntities, Claim::kIgnoredPairs);

constexpr uint32_t kBits = static_cast<uint32_t>(EntityField::kIgnoredEntities);

EntityDesc Ignoring(EntityDesc desc, std::vector<EntityId> others) {
  desc.rigid_body->ignored_entities = std::move(others);
  return desc;
}

void SetIgnored(World& world, EntityId id, std::vector<EntityId> others) {
  Do(world, UpdateEntity{id, Ignoring(*world.Describe(id), std::move(others)), {kBits}});
}

TEST_P(IgnoredEntities, FallThroughEachOtherAndTouchAllElse) {
  const auto world = MakeWorld();
  const EntityId shelf = Add(*world, Block({0, 0, 2}, {2, 2, 0.1}));
  const EntityId falls = Add(*world, Ignoring(Ball({-1, 0, 4}), {shelf}));
  const EntityId lands = Add(*world, Ball({1, 0, 4}));
  Steps(*world, 240);
  EXPECT_NEAR(PositionOf(*world, falls).z(), 0.5, kTouch) << "the floor holds it";
  EXPECT_NEAR(PositionOf(*world, lands).z(), 2.6, kTouch);
}

TEST_P(IgnoredEntities, NeedOneSideThatNamesTheOther) {
  const auto world = MakeWorld();
  const EntityId low = Add(*world, Crate({0, 0, 0.5}));
  const EntityId high = Add(*world, Ignoring(Crate({0, 0, 1.5}), {low}));
  Steps(*world, 120);
  EXPECT_NEAR(PositionOf(*world, high).z(), 0.5, kTouch) << "inside the other";
  EXPECT_NEAR(PositionOf(*world, low).z(), 0.5, kTouch) << "which feels nothing of it";
  EXPECT_NEAR(PositionOf(*world, low).head<2>().norm(), 0, 2 * SweptSpeed(0.5 * 9.81, SubstepOf(*world)) * 2)
      << "in two seconds";
}

TEST_P(IgnoredEntities, WakeWhoSleepsOnThemWhicheverSideNamesTheOther) {
  Proves({Claim::kSleeping});
  for (const bool shelf_names : {false, true}) {
    for (const bool is_between_engines : {false, true}) {
      const auto world = MakeWorld();
      const EntityId shelf = Add(*world, Block({0, 0, 2}, {2, 2, 0.1}));
      const EntityId ball = Add(*world, Ball({0, 0, 2.6}));
      Steps(*world, 120);
      ASSERT_TRUE(Asleep(*world, ball));
      if (is_between_engines) Do(*world, SetEngine{"none"});
      shelf_names ? SetIgnored(*world, shelf, {ball}) : SetIgnored(*world, ball, {shelf});
      if (is_between_engines) Do(*world, SetEngine{GetParam()});
      Steps(*world, 120);
      EXPECT_NEAR(PositionOf(*world, ball).z(), 0.5, kTouch) << shelf_names << is_between_engines;
    }
  }
}

TEST_P(IgnoredEntities, SlideThroughWhatTheyFlyPast) {
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  const EntityId still = Add(*world, Ball({0, 0, 0}));
  EntityDesc ball = Ball({-3, 0, 0});
  ball.rigid_body->linear_velocity = {2, 0, 0};
  const EntityId flies = Add(*world, Ignoring(ball, {still}));
  Steps(*world, 180);
  EXPECT_NEAR(PositionOf(*world, flies).x(), 3, kRounded);
  EXPECT_EQ(PositionOf(*world, still), Vector3(0, 0, 0));
}

TEST_P(IgnoredEntities, AreIgnoredBySensorsToo) {
  Proves({Claim::kSensors});
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  EntityDesc gate = Block({0, 0, 0}, {1, 1, 1});
  gate.rigid_body->geometries[0].is_sensor = true;
  const EntityId sensor = Add(*world, gate);
  const EntityId unseen = Add(*world, Ignoring(Ball({0, 0, 0}, 0.1), {sensor}));
  const EntityId seen = Add(*world, Ignoring(Ball({0, 0, 0}, 0.1), {unseen}));
  Steps(*world, 2);
  const std::vector<SensorEntered> entered = Of<SensorEntered>(world->TakeEvents());
  ASSERT_EQ(entered.size(), 1u);
  EXPECT_EQ(entered[0].visitor, seen);
}

TEST_P(IgnoredEntities, TouchAgainOnceNobodyNamesTheOther) {
  const auto world = MakeWorld();
  const EntityId shelf = Add(*world, Block({0, 0, 2}, {2, 2, 0.1}));
  const EntityId box = Add(*world, Crate({0, 0, 2.6}));
  Steps(*world, 60);
  ASSERT_NEAR(PositionOf(*world, box).z(), 2.6, kTouch);
  world->TakeEvents();
  SetIgnored(*world, box, {shelf});
  Steps(*world, 15);
  EXPECT_LT(PositionOf(*world, box).z(), 2.5) << "a live change lets it fall";
  EXPECT_EQ(Of<ContactEnded>(world->TakeEvents()).size(), 1u);
  SetIgnored(*world, shelf, {box});
  SetIgnored(*world, box, {});
  Steps(*world, 60);
  EXPECT_NEAR(PositionOf(*world, box).z(), 0.5, kTouch) << "one side still names the other";
  SetIgnored(*world, shelf, {});
  Do(*world, SetPose{.id = box, .position = Vector3(0, 0, 4)});
  Steps(*world, 120);
  EXPECT_NEAR(PositionOf(*world, box).z(), 2.6, kTouch);
}

TEST_P(IgnoredEntities, WakeWhenTheyAreToldSo) {
  Proves({Claim::kSleeping});
  const auto world = MakeWorld();
  const EntityId low = Add(*world, Crate({0, 0, 0.5})), high = Add(*world, Crate({0, 0, 1.5}));
  Steps(*world, 240);
  ASSERT_TRUE(Asleep(*world, high));
  SetIgnored(*world, low, {high});
  EXPECT_FALSE(Asleep(*world, high));
  Steps(*world, 60);
  EXPECT_NEAR(PositionOf(*world, high).z(), 0.5, kTouch);
}

TEST_P(IgnoredEntities, WakeWhoSleepsInsideThemOnceTheyAreNot) {
  Proves({Claim::kSleeping});
  for (const MotionType motion : {MotionType::kStatic, MotionType::kKinematic}) {
    for (const bool sleeper_names : {false, true}) {
      const auto world = MakeWorld();
      const EntityId ball = Add(*world, Ball({0, 0, 0.5})), other = Add(*world, Ball({9, 0, 0.5}));
      EntityDesc wedge = Ball({0.7, 0, 0.5});
      wedge.rigid_body->motion_type = motion;
      const EntityId inside = Add(*world, Ignoring(wedge, {ball}));
      if (sleeper_names) {
        SetIgnored(*world, ball, {inside});
        SetIgnored(*world, inside, {});
      }
      Steps(*world, 120);
      ASSERT_TRUE(Asleep(*world, ball) && Asleep(*world, other));
      SetIgnored(*world, sleeper_names ? ball : inside, {});
      EXPECT_FALSE(Asleep(*world, ball));
      EXPECT_TRUE(Asleep(*world, other)) << "it is elsewhere";
      Steps(*world, 60);
      EXPECT_LT(PositionOf(*world, ball).x(), -0.2) << "it is pushed out";
    }
  }
}

TEST_P(IgnoredEntities, AreStillIgnoredWithAnotherShapeAndOnAnotherEngine) {
  Proves({Claim::kLiveChange, Claim::kEngineChange});
  const auto world = MakeWorld();
  const EntityId shelf = Add(*world, Block({0, 0, 2}, {2, 2, 0.1}));
  const EntityId ball = Add(*world, Ignoring(Ball({0, 0, 40}), {shelf}));
  Steps(*world, 2);
  EntityDesc other = Crate({0, 0, 40});
  Do(*world, UpdateEntity{ball, other, {static_cast<uint32_t>(EntityField::kGeometries)}});
  Do(*world, SetEngine{OtherEngine(GetParam())});
  EXPECT_EQ(world->Describe(ball)->rigid_body->ignored_entities, std::vector<EntityId>{shelf});
  Do(*world, SetPose{.id = ball, .position = Vector3(0, 0, 4)});
  Steps(*world, 240);
  EXPECT_NEAR(PositionOf(*world, ball).z(), 0.5, kTouch);
}

TEST_P(IgnoredEntities, AreForgottenWithTheOneThatIsGone) {
  const auto world = MakeWorld();
  const EntityId shelf = Add(*world, Block({0, 0, 2}, {2, 2, 0.1}));
  const EntityId ball = Add(*world, Ignoring(Ball({0, 0, 4}), {shelf}));
  Do(*world, DeleteEntity{shelf});
  const EntityId same_row = Add(*world, Block({0, 0, 2}, {2, 2, 0.1}));
  ASSERT_EQ(same_row.index(), shelf.index());
  Steps(*world, 120);
  EXPECT_NEAR(PositionOf(*world, ball).z(), 2.6, kTouch) << "who takes its place is another";
}

TEST_P(IgnoredEntities, AreTheSameAfterAReset) {
  const auto world = MakeWorld();
  const EntityId shelf = Add(*world, Block({0, 0, 2}, {2, 2, 0.1}));
  const EntityId ball = Add(*world, Ignoring(Ball({0, 0, 4}), {shelf}));
  Steps(*world, 5);
  SetIgnored(*world, ball, {});
  world->Reset();
  Steps(*world, 240);
  EXPECT_NEAR(PositionOf(*world, ball).z(), 0.5, kTouch);
}

TEST_P(IgnoredEntities, MustExistWhenTheyAreNamed) {
  const auto world = MakeWorld();
  const EntityId gone = Add(*world, Ball({0, 0, 4})), there = Add(*world, Ball({3, 0, 4}));
  Do(*world, DeleteEntity{gone});
  for (const EntityId id : {EntityId(), EntityId::FromPacked(987654321), gone}) {
    const Command create = CreateEntity{Ignoring(Ball({0, 0, 9}), {there, id})};
    const std::optional<Refusal> refusal = RefusalOf(world->Apply({&create, 1}).status());
    ASSERT_TRUE(refusal);
    EXPECT_EQ(refusal->field, "commands[0].create_entity.entity.rigid_body.ignored_entity_ids[1]");
  }
  Add(*world, Ignoring(Ball({0, 0, 9}), {there, there}));
}

}  // namespace
}  // namespace genphys::testing

// Joints and force fields that come, change and go are told of, and a field may name what its batch creates.
#include <cmath>

#include "engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Changes, Claim::kChangeEvents);

constexpr double kGravity = 9.81;

TEST_P(Changes, AreToldOfJoints) {
  const auto world = MakeSpace(GetParam(), {}, {0, 0, -kGravity});
  const EntityId a = Add(*world, Ball({0, 0, 0})), b = Add(*world, Ball({2, 0, 0}));
  world->TakeEvents();
  const JointId joint = Join(*world, Between(a, b, HingeJoint{}));
  const auto created = Of<JointCreated>(world->TakeEvents());
  ASSERT_EQ(created.size(), 1u);
  EXPECT_EQ(created[0].joint, joint);
  EXPECT_EQ(created[0].pair, (EntityPair{a, b}));
  EXPECT_TRUE(created[0].desc->frame_in_a && created[0].desc->frame_in_b) << "as it is, with both frames";

  JointDesc weaker = *created[0].desc;
  weaker.break_force = 1e6;
  Do(*world, UpdateJoint{joint, weaker, {static_cast<uint32_t>(JointField::kBreakForce)}});
  const auto updated = Of<JointUpdated>(world->TakeEvents());
  ASSERT_EQ(updated.size(), 1u);
  EXPECT_EQ(updated[0].desc->break_force, 1e6);
  EXPECT_TRUE(updated[0].fields.Has(JointField::kBreakForce));

  const JointId other = Join(*world, ToWorld(b, BallJoint{}));
  world->TakeEvents();
  Do(*world, DeleteJoint{joint});
  EXPECT_EQ(Of<JointDeleted>(world->TakeEvents()).at(0).joint, joint);
  Do(*world, DeleteEntity{b});
  const auto gone = Of<JointDeleted>(world->TakeEvents());
  ASSERT_EQ(gone.size(), 1u) << "with its entity";
  EXPECT_EQ(gone[0].joint, other);
  EXPECT_EQ(gone[0].pair, (EntityPair{EntityId(), b}));
}

TEST_P(Changes, WhoIsOutOfTheWorldIsToldOfWhereTheyAreAndNowhereElse) {
  Proves({Claim::kFaultEvents});
  for (const bool are_told : {false, true}) {
    WorldDesc desc{.engine = GetParam(), .ground_plane = false};
    desc.recorded_events.changes = are_told;
    const auto world = testing::MakeWorld(desc);
    EntityDesc rocket = Ball({1e7 - 1, 0, 5});
    rocket.rigid_body->linear_velocity = {1e5, 0, 0};
    const EntityId id = Add(*world, rocket);
    world->TakeEvents();
    const uint64_t next = world->layer_state().next_event_sequence;

    Steps(*world, 3);

    EXPECT_TRUE(Asleep(*world, id)) << "it is out, told or not";
    EXPECT_EQ(Of<EntityFaulted>(world->TakeEvents()).size(), are_told ? 1u : 0u);
    EXPECT_EQ(world->layer_state().next_event_sequence, next + (are_told ? 1 : 0));
  }
}

TEST_P(Changes, AreToldOfForceFields) {
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  const EntityId a = Add(*world, Ball({0, 0, 0})), b = Add(*world, Ball({2, 0, 0}));
  world->TakeEvents();
  const ForceFieldId push = Do(*world, CreateForceField{{.kind = UniformField{}, .entities = {a, b}}}).packed();
  const ForceFieldId spring = Do(*world, CreateForceField{{.kind = SpringField{.a = a, .b = b}}}).packed();
  const auto created = Of<ForceFieldCreated>(world->TakeEvents());
  ASSERT_EQ(created.size(), 2u);
  EXPECT_EQ(created[0].field, push);
  EXPECT_EQ(created[1].pair, (EntityPair{a, b}));

  Do(*world, UpdateForceField{push, {.kind = DragField{.linear = 1}, .entities = {a, b}}});
  EXPECT_EQ(Of<ForceFieldUpdated>(world->TakeEvents()).at(0).desc->kind.index(), 1u);

  Do(*world, DeleteEntity{a});
  const std::vector<Event> events = world->TakeEvents();
  EXPECT_EQ(Of<ForceFieldDeleted>(events).at(0).field, spring) << "it holds nothing any more";
  EXPECT_EQ(Of<ForceFieldUpdated>(events).at(0).desc->entities, std::vector<EntityId>{b});
  Do(*world, DeleteForceField{push});
  EXPECT_EQ(Of<ForceFieldDeleted>(world->TakeEvents()).at(0).field, push);
}

TEST_P(Changes, AreToldInOneOrderWhateverTheOrderOfTheCommands) {
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  const EntityId old = Add(*world, Ball({9, 0, 0})), held = Add(*world, Ball({0, 9, 0}));
  const JointId joint = Join(*world, ToWorld(held, BallJoint{}));
  world->TakeEvents();
  JointDesc pair = Between(EntityId(), EntityId(), HingeJoint{});
  pair.entity_a = {.created_by_command = 1};
  pair.entity_b = {.created_by_command = 3};
  EntityDesc renamed = *world->Describe(held);
  renamed.display_name = "held";
  const std::vector<Command> batch{
      DeleteJoint{joint},
      CreateEntity{Ball({0, 0, 0})},
      DeleteEntity{old},
      CreateEntity{Ball({2, 0, 0})},
      CreateForceField{{.kind = UniformField{}}},
      CreateJoint{pair},
      UpdateEntity{held, renamed, {static_cast<uint32_t>(EntityField::kDisplayName)}},
  };
  ASSERT_TRUE(world->Apply(batch).ok());

  const std::vector<Event> events = world->TakeEvents();

  ASSERT_EQ(events.size(), batch.size());
  for (size_t i = 1; i < events.size(); ++i) {
    EXPECT_EQ(events[i].sequence, events[i - 1].sequence + 1);
    EXPECT_LE(events[i - 1].kind.index(), events[i].kind.index());
  }
  EXPECT_TRUE(std::holds_alternative<EntityCreated>(events.front().kind)) << "nobody is named before";
  EXPECT_TRUE(std::holds_alternative<EntityDeleted>(events.back().kind)) << "nor after";
}

TEST_P(Changes, AForceFieldNamesWhatItsBatchCreates) {
  constexpr double kStiffness = 1, kReach = 3;
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  const std::vector<Command> batch{CreateEntity{Ball({0, 0, 0})}, CreateEntity{Ball({kReach, 0, 0})},
                                   CreateEntity{Ball({0, 5, 0})},
                                   CreateForceField{{.kind = UniformField{.acceleration = {0, 1, 0}}}, {2}},
                                   CreateForceField{{.kind = SpringField{.stiffness = kStiffness}}, {}, 0, 1}};
  const Result<std::vector<CreatedId>> created = world->Apply(batch);
  ASSERT_TRUE(created.ok()) << created.status();
  const EntityId a = (*created)[0], b = (*created)[1], pushed = (*created)[2];

  Steps(*world, 1);

  // Of a swing whose square of w h is 2 k h^2: a sixth of that is what pulls less on the mean of the step.
  constexpr double kPull = kStiffness * kReach / 60, kTolerance = 2 * (2 * kStiffness / 3600) / 6 * kPull;
  EXPECT_NEAR(VelocityOf(*world, a).x(), kPull, kTolerance);
  EXPECT_NEAR(VelocityOf(*world, b).x(), -kPull, kTolerance);
  EXPECT_NEAR(VelocityOf(*world, pushed).y(), 1.0 / 60, kRounded);
  EXPECT_EQ(VelocityOf(*world, a).y(), 0) << "the push is on its own entity";

  const auto refused = [&](std::vector<Command> commands) {
    const auto refusal = RefusalOf(world->Apply(commands).status());
    return refusal ? refusal->field : "accepted";
  };
  EXPECT_EQ(refused({CreateForceField{{.kind = UniformField{}}, {0}}}),
            "commands[0].create_force_field.created_by_commands[0]");
  EntityDesc still = Ball({0, 0, 0});
  still.rigid_body->motion_type = MotionType::kStatic;
  EXPECT_EQ(refused({CreateEntity{still}, CreateForceField{{.kind = UniformField{}}, {0}}}),
            "commands[1].create_force_field.created_by_commands[0]");
  EXPECT_EQ(refused({CreateForceField{{.kind = SpringField{}}, {}, 3}}),
            "commands[0].create_force_field.spring_a_created_by_command");
  EXPECT_EQ(refused({CreateEntity{Ball({0, 0, 0})}, CreateForceField{{.kind = UniformField{}}, {}, 0}}),
            "commands[1].create_force_field.spring_a_created_by_command");
}

}  // namespace
}  // namespace genphys::testing

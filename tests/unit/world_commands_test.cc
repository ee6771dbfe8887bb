// What a world accepts, what it refuses, and that a refusal changes nothing.
#include <gtest/gtest.h>

#include <limits>

#include "genphys/limits.h"
#include "genphys/surface.h"
#include "support/scenes.h"

namespace genphys::testing {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Scene {
  std::unique_ptr<World> world = MakeWorld("none");
  EntityId ball = Add(*world, Ball({0, 0, 2}));
};

void ExpectRefused(World& world, const std::vector<Command>& commands, Reason reason, const std::string& field) {
  const uint64_t before = world.StateHash();

  const Result<std::vector<CreatedId>> result = world.Apply(commands);

  ASSERT_FALSE(result.ok()) << field;
  const std::optional<Refusal> refusal = RefusalOf(result.status());
  ASSERT_TRUE(refusal.has_value()) << result.status();
  EXPECT_EQ(refusal->reason, reason) << result.status();
  EXPECT_EQ(refusal->field, field);
  EXPECT_EQ(world.StateHash(), before);
}

TEST(Commands, ABatchIsAppliedWholeOrNotAtAll) {
  Scene scene;
  const uint32_t count = scene.world->entity_count();

  ExpectRefused(*scene.world,
                {CreateEntity{Ball({5, 0, 1})}, SetVelocity{.id = scene.ball, .linear = Vector3(1, 0, 0)},
                 ApplyForce{.id = scene.ball, .force = {kNan, 0, 0}}},
                Reason::kNotFinite, "commands[2].apply_force.force.x");

  EXPECT_EQ(scene.world->entity_count(), count);
  EXPECT_TRUE(scene.world->Apply(std::vector<Command>{CreateEntity{Ball({5, 0, 1})}}).ok());
}

TEST(Commands, SeeWhatEarlierOnesOfTheBatchDid) {
  Scene scene;
  ExpectRefused(*scene.world, {DeleteEntity{scene.ball}, SetPose{.id = scene.ball, .position = Vector3(0, 0, 0)}},
                Reason::kStaleId, "commands[1].set_pose.entity_id");
  ExpectRefused(*scene.world, {DeleteEntity{scene.ball}, DeleteEntity{scene.ball}}, Reason::kStaleId,
                "commands[1].delete_entity.entity_id");

  UpdateEntity to_static{.id = scene.ball, .entity = Block({0, 0, 0}, {1, 1, 1}), .fields = {}};
  to_static.fields.Add(EntityField::kMotionType);
  ExpectRefused(*scene.world, {to_static, ApplyForce{.id = scene.ball, .force = {1, 0, 0}}}, Reason::kInvalidValue,
                "commands[1].apply_force.entity_id");
}

TEST(Commands, LetNoMoreForcesWaitThanAWorldHolds) {
  Scene scene;
  const size_t half = Limits::kPendingForcesMax / 2;
  const ApplyForceColumns many{.ids = std::vector(half, scene.ball), .forces = std::vector(half, Vector3(1, 0, 0))};
  const ApplyForceColumns column{.ids = {scene.ball}, .forces = {Vector3(1, 0, 0)}};
  ApplyForce one{.id = scene.ball, .force = {1, 0, 0}, .steps = 1000};
  ExpectRefused(*scene.world, {many, many, one}, Reason::kLimitExceeded, "commands[2].apply_force.entity_id");
  ASSERT_TRUE(scene.world->Apply(std::vector<Command>{many, many}).ok());

  ExpectRefused(*scene.world, {one}, Reason::kLimitExceeded, "commands[0].apply_force.entity_id");
  ExpectRefused(*scene.world, {column}, Reason::kLimitExceeded, "commands[0].apply_forces.entity_ids");
  one.replace = true;
  Do(*scene.world, one);
  EXPECT_EQ(scene.world->layer_state().forces.size(), 1u);
  Do(*scene.world, column);
}

TEST(Commands, MakeNoMoreGeometriesThanAWorldHolds) {
  Scene scene;
  const auto with = [](size_t count) {
    EntityDesc desc = Ball({0, 0, 0});
    desc.rigid_body->motion_type = MotionType::kStatic;
    desc.rigid_body->geometries.assign(count, Geometry{.shape = Sphere{}});
    return desc;
  };
  // The ball is one, and the world has a ground.
  const size_t left = Limits::kWorldGeometriesMax - 2, most = Limits::kGeometriesMax;
  std::vector<Command> batch(left / most, CreateEntity{with(most)});
  batch.push_back(CreateEntity{with(left % most + 1)});
  const std::string last = "commands[" + std::to_string(batch.size() - 1) + "].";
  ExpectRefused(*scene.world, batch, Reason::kLimitExceeded, last + "create_entity.entity.rigid_body.geometries");
  batch.back() = CreateEntity{with(left % most)};
  const Result<std::vector<CreatedId>> created = scene.world->Apply(batch);
  ASSERT_TRUE(created.ok()) << created.status();

  UpdateEntity more{.id = EntityId::FromPacked(created->front().packed()), .entity = with(most - 1), .fields = {}};
  more.fields.Add(EntityField::kGeometries);
  UpdateEntity whole = more;
  whole.entity = with(most);
  const CreateEntity another{with(1)};
  ExpectRefused(*scene.world, {another}, Reason::kLimitExceeded,
                "commands[0].create_entity.entity.rigid_body.geometries");
  ExpectRefused(*scene.world, {more, another, whole}, Reason::kLimitExceeded,
                "commands[2].update_entity.entity.rigid_body.geometries");
  Do(*scene.world, more);
  Do(*scene.world, another);
  ExpectRefused(*scene.world, {another}, Reason::kLimitExceeded,
                "commands[0].create_entity.entity.rigid_body.geometries");
  EXPECT_TRUE(scene.world->Apply(std::vector<Command>{DeleteEntity{scene.ball}, another}).ok());
}

TEST(Commands, MakeNoMoreShapesThanAWorldHasMemoryForAndCountCopiesOnce) {
  Scene scene;
  const auto field = [](double height) {
    constexpr uint32_t kSide = Limits::kHeightfieldSideMax;
    EntityDesc desc = Ball({0, 0, 0});
    desc.rigid_body->motion_type = MotionType::kStatic;
    desc.rigid_body->geometries = {
        {.shape = *MakeHeightfield(kSide, kSide, 1, std::vector<double>(kSide * kSide, height))}};
    return desc;
  };
  const CreateEntity first{field(0)};
  const size_t bytes = DataBytesOf(first.entity.rigid_body->geometries[0].shape);
  const size_t room = (size_t{Limits::kShapeMebibytesMax} << 20) / bytes;
  std::vector<Command> batch(2 * room, first);
  ASSERT_TRUE(scene.world->Apply(batch).ok()) << "they are all the same";

  batch.clear();
  for (size_t i = 1; i <= room; ++i) batch.push_back(CreateEntity{field(static_cast<double>(i))});
  ExpectRefused(*scene.world, batch, Reason::kLimitExceeded,
                "commands[" + std::to_string(room - 1) + "].create_entity.entity.rigid_body.geometries[0].shape");
  batch.pop_back();
  EXPECT_TRUE(scene.world->Apply(batch).ok());
}

TEST(Commands, TellNullForgedAndStaleIdsApart) {
  Scene scene;
  const EntityId gone = Add(*scene.world, Ball({9, 0, 1}));
  Do(*scene.world, DeleteEntity{gone});
  const auto remove = [](uint64_t packed) { return std::vector<Command>{DeleteEntity{EntityId::FromPacked(packed)}}; };
  const std::string field = "commands[0].delete_entity.entity_id";

  ExpectRefused(*scene.world, remove(0), Reason::kMissingField, field);
  ExpectRefused(*scene.world, remove(gone.packed()), Reason::kStaleId, field);
  ExpectRefused(*scene.world, remove(1000), Reason::kEntityNotFound, field);
  ExpectRefused(*scene.world, remove(uint64_t{1} << 32), Reason::kEntityNotFound, field);
  ExpectRefused(*scene.world, remove(~uint64_t{0}), Reason::kEntityNotFound, field);
  ExpectRefused(*scene.world, remove(EntityId(scene.ball.index(), 7).packed()), Reason::kEntityNotFound, field);
}

TEST(Commands, AreAcceptedAtTheLimitAndRefusedBeyondIt) {
  Scene scene;
  const double beyond = std::nextafter(Limits::kForceMax, kInfinity);
  const auto push = [&](double x) { return std::vector<Command>{ApplyForce{.id = scene.ball, .force = {0, x, 0}}}; };

  EXPECT_TRUE(scene.world->Apply(push(Limits::kForceMax)).ok());
  EXPECT_TRUE(scene.world->Apply(push(-Limits::kForceMax)).ok());
  ExpectRefused(*scene.world, push(beyond), Reason::kOutOfRange, "commands[0].apply_force.force.y");
  ExpectRefused(*scene.world, push(kInfinity), Reason::kNotFinite, "commands[0].apply_force.force.y");
}

TEST(Commands, NameTheFieldDeepInsideAnEntity) {
  Scene scene;
  EntityDesc desc = Ball({0, 0, 0});
  desc.rigid_body->geometries.push_back({.shape = Box{{1, -1, 1}}});
  ExpectRefused(*scene.world, {CreateEntity{desc}}, Reason::kOutOfRange,
                "commands[0].create_entity.entity.rigid_body.geometries[1].shape.box.half_extents.y");

  desc = Ball({0, 0, 0});
  desc.pose.orientation = Quaternion(0, 0, 0, 0);
  ExpectRefused(*scene.world, {CreateEntity{desc}}, Reason::kNotUnitLength,
                "commands[0].create_entity.entity.pose.orientation");

  desc = Ball({0, 0, 0});
  desc.rigid_body->inertia.tensor = Vector3(1, 1, 3).asDiagonal();
  ExpectRefused(*scene.world, {CreateEntity{desc}}, Reason::kInvalidValue,
                "commands[0].create_entity.entity.rigid_body.inertia.tensor");

  ExpectRefused(*scene.world, {CreateEntity{Body(Plane{}, {0, 0, 0})}}, Reason::kInvalidValue,
                "commands[0].create_entity.entity.rigid_body.geometries[0].shape.plane");
}

TEST(Commands, OfColumnsNameTheRowAndTheComponent) {
  Scene scene;
  ApplyForceColumns columns{.ids = {scene.ball, scene.ball}, .forces = {{1, 2, 3}, {4, 5, kNan}}, .torques = {}};
  ExpectRefused(*scene.world, {columns}, Reason::kNotFinite, "commands[0].apply_forces.forces[1].z");

  columns.forces.pop_back();
  ExpectRefused(*scene.world, {columns}, Reason::kInvalidValue, "commands[0].apply_forces.forces");

  columns = {.ids = {scene.ball, EntityId(900, 0)}, .forces = {{1, 2, 3}, {4, 5, 6}}, .torques = {}};
  ExpectRefused(*scene.world, {columns}, Reason::kEntityNotFound, "commands[0].apply_forces.entity_ids[1]");
}

TEST(Commands, AnEngineThatIsNotThereOrLacksAFeatureIsRefusedByName) {
  Scene scene;
  ExpectRefused(*scene.world, {SetEngine{"havok"}}, Reason::kInvalidValue, "commands[0].set_engine.engine");
  // The floor is a plane, and flight alone knows none.
  ExpectRefused(*scene.world, {SetEngine{"ballistic"}}, Reason::kUnsupportedFeature, "commands[0].set_engine.engine");
}

TEST(Commands, AnUpdateReplacesWhatItNamesAndKeepsTheRest) {
  Scene scene;
  Do(*scene.world, SetVelocity{.id = scene.ball, .linear = Vector3(1, 2, 3)});
  UpdateEntity heavier{.id = scene.ball, .entity = Ball({7, 7, 7}, 0.5, 4), .fields = {}};
  heavier.fields.Add(EntityField::kInertia);

  Do(*scene.world, heavier);

  EXPECT_EQ(scene.world->scene().entities[scene.ball.index()]->mass.mass, 4);
  EXPECT_EQ(PositionOf(*scene.world, scene.ball), Vector3(0, 0, 2));
  EXPECT_EQ(VelocityOf(*scene.world, scene.ball), Vector3(1, 2, 3));
}

TEST(Commands, PhysicsCanBeTakenFromAnEntityAndGivenBack) {
  Scene scene;
  UpdateEntity update{.id = scene.ball, .entity = {}, .fields = {}};
  update.fields.Add(EntityField::kRigidBody);
  Do(*scene.world, update);
  ExpectRefused(*scene.world, {ApplyForce{.id = scene.ball, .force = {1, 0, 0}}}, Reason::kInvalidValue,
                "commands[0].apply_force.entity_id");

  update.entity = Ball({0, 0, 0});
  Do(*scene.world, update);

  Do(*scene.world, ApplyForce{.id = scene.ball, .force = {1, 0, 0}});
  EXPECT_EQ(PositionOf(*scene.world, scene.ball), Vector3(0, 0, 2)) << "the pose was not named";
}

TEST(Commands, AreToldAsEvents) {
  Scene scene;
  scene.world->TakeEvents();
  const EntityId crate = Add(*scene.world, Crate({3, 0, 1}));
  Do(*scene.world, DeleteEntity{crate});

  const std::vector<Event> events = scene.world->TakeEvents();

  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(std::get<EntityCreated>(events[0].kind).id, crate);
  EXPECT_EQ(std::get<EntityDeleted>(events[1].kind).id, crate);
  EXPECT_EQ(events[1].sequence, events[0].sequence + 1);
}

TEST(Reset, BringsBackWhatWasThereBeforeTheFirstStep) {
  const auto world = MakeWorld("ode");
  const EntityId ball = Add(*world, Ball({0, 0, 2}));
  const uint64_t before = world->StateHash();
  Steps(*world, 30);
  Do(*world, DeleteEntity{ball});
  Add(*world, Crate({5, 0, 5}));
  Steps(*world, 30);

  world->Reset();

  EXPECT_EQ(world->layer_state().step, 0u);
  EXPECT_EQ(PositionOf(*world, ball), Vector3(0, 0, 2));
  EXPECT_EQ(world->StateHash(), before);
}

// Who does the same again tells them again.
TEST(Reset, BringsBackNoForces) {
  const auto world = MakeWorld("ode");
  const EntityId ball = Add(*world, Ball({0, 0, 200}));
  std::vector<Vector3> velocities;
  for (int episode = 0; episode < 3; ++episode) {
    Do(*world, ApplyForce{.id = ball, .force = {5, 0, 0}, .steps = 10});
    Do(*world, ApplyForce{.id = ball, .force = {0, 3, 0}, .sampled = true});
    Steps(*world, 20);
    velocities.push_back(VelocityOf(*world, ball));
    world->Reset();
  }
  EXPECT_GT(velocities[0].x(), 0);
  EXPECT_EQ(velocities[1], velocities[0]);
  EXPECT_EQ(velocities[2], velocities[0]);
}

TEST(Reset, GoesBackToTheBeginningThatWasMarkedUnlessThatIsForgotten) {
  for (const bool is_forgotten : {false, true}) {
    const auto world = MakeWorld("ode");
    world->MarkBeginning();
    const EntityId ball = Add(*world, Ball({0, 0, 2}));
    if (is_forgotten) world->ForgetBeginning();
    Steps(*world, 3);
    world->ForgetBeginning();  // which comes too late

    world->Reset();

    EXPECT_EQ(world->scene().entities.size() > ball.index() && world->scene().entities[ball.index()].has_value(),
              is_forgotten);
  }
}

class ResetOn : public ::testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Engines, ResetOn, ::testing::ValuesIn(EnginesWithContacts()));

// Rows that became free before the first step are given out otherwise after a reset.
TEST_P(ResetOn, LeadsToTheSameHashesInWhateverRowsGeometriesAre) {
  const auto world = MakeWorld(GetParam());
  const EntityId other = Add(*world, Crate({50, 0, 1}));
  const EntityId first = Add(*world, Crate({0, 0, 1})), second = Add(*world, Crate({0.2, 0, 2.2}));
  Do(*world, DeleteEntity{other});
  constexpr EntityFields kGeometries{static_cast<uint32_t>(EntityField::kGeometries)};
  Do(*world, UpdateEntity{.id = first, .entity = Crate({0, 0, 1}), .fields = kGeometries});
  Do(*world, DeleteEntity{Add(*world, Crate({60, 0, 1}))});
  Do(*world, UpdateEntity{.id = second, .entity = Crate({0.2, 0, 2.2}), .fields = kGeometries});
  const auto run = [&] {
    std::vector<uint64_t> hashes;
    for (int i = 0; i < 60; ++i) {
      Steps(*world, 1);
      hashes.push_back(world->StateHash());
    }
    return hashes;
  };

  const std::vector<uint64_t> before = run();
  world->Reset();

  EXPECT_EQ(run(), before);
}

TEST(Reset, GivesOutTheSameIdsAgain) {
  Scene scene;
  Steps(*scene.world, 1);
  const EntityId late = Add(*scene.world, Ball({5, 0, 2})), last = Add(*scene.world, Ball({8, 0, 2}));

  scene.world->Reset();

  ExpectRefused(*scene.world, {DeleteEntity{late}}, Reason::kEntityNotFound, "commands[0].delete_entity.entity_id");
  EXPECT_EQ(Add(*scene.world, Crate({3, 0, 1})), late);
  EXPECT_EQ(Add(*scene.world, Crate({9, 0, 1})), last);
  Do(*scene.world, DeleteEntity{scene.ball});
}

TEST(Worlds, AreRefusedWithTheFieldThatIsWrong) {
  const auto refusal = [](const WorldDesc& desc) {
    const Result<std::unique_ptr<World>> world = World::Create(Engines(), desc);
    return world.ok() ? Refusal{} : *RefusalOf(world.status());
  };
  EXPECT_EQ(refusal({.engine = "havok"}).field, "engine");
  EXPECT_EQ(refusal({.gravity = {0, 0, kNan}}).field, "gravity.z");
  EXPECT_EQ(refusal({.stepper = {.step_size = 1}}).field, "stepper.step_size_seconds");
  EXPECT_EQ(refusal({.engine = "ballistic", .ground_plane = true}).field, "ground_plane");
  EXPECT_EQ(refusal({.engine = "ballistic", .stepper = {.solver = Solver::kDirect}}).field, "stepper.solver");
  EXPECT_EQ(refusal({.required_features = {Feature::kExactSnapshot}}).reason, Reason::kUnsupportedFeature);
  EXPECT_EQ(refusal({.engine = "ballistic", .required_features = {Feature::kSolverDirect}}).field, "engine");
}

}  // namespace
}  // namespace genphys::testing

// The C++ client against a real server, on every engine that has contacts.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "genphys/client/client.h"
#include "support/scenes.h"
#include "support/test_server.h"

namespace genphys::client {
namespace {

constexpr double kGravity = 9.81;
constexpr double kStepSize = 1.0 / 240;

using genphys::testing::TestServer;

Result<World> MakeWorld(const TestServer& server, const std::string& engine, const WorldOptions& options = {}) {
  WorldOptions with_engine = options;
  with_engine.world.engine = engine;
  with_engine.world.gravity = {0, 0, -kGravity};
  with_engine.world.stepper.step_size = kStepSize;
  return Connect(server.address())->CreateWorld(with_engine);
}

class CppClient : public ::testing::TestWithParam<std::string> {
 protected:
  TestServer server_;
  World world_ = *MakeWorld(server_, GetParam());
};

INSTANTIATE_TEST_SUITE_P(Engines, CppClient, ::testing::ValuesIn(genphys::testing::EnginesWithContacts()),
                         [](const auto& named) { return named.param; });

TEST_P(CppClient, BringsCommandsInAndAFrameAndEventsOutInOneCall) {
  // Before its body is created an entity has no id, so the command that names it comes a call later.
  const Result<StepResult> created =
      world_.Step(0, {.commands = {CreateEntity{Body(Sphere{}, {.position = {0, 0, 5}, .mass = 2})}}});
  ASSERT_TRUE(created.ok()) << created.status();
  const EntityId ball = created->created[0];

  const genphys::ApplyForce lift{.id = ball, .force = {0, 0, 2 * kGravity}, .steps = 240};
  const Result<StepResult> result = world_.Step(240, {.commands = {lift}, .stats = true});

  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->stamp.step, 240u);
  constexpr double kForceErrors = 1e-9;  // weight and lift cancel up to rounding
  EXPECT_NEAR(result->frame.positions()(2, *result->frame.row(ball)), 5, kForceErrors);
  EXPECT_TRUE(result->stats.has_value());
  ASSERT_EQ(created->events.size(), 1u);
  EXPECT_EQ(std::get<EntityCreated>(created->events[0].kind).id, ball);
}

TEST_P(CppClient, StepsManyWorldsInOneCall) {
  const Server connection = *Connect(server_.address());
  std::vector<World> worlds;
  for (int i = 0; i < 3; ++i) {
    worlds.push_back(*MakeWorld(server_, GetParam()));
    ASSERT_TRUE(worlds.back().Add(Sphere{}, {.position = {0, 0, 1.0 + i}, .mass = 1}).ok());
  }
  std::vector<WorldSteps> wanted;
  for (const World& world : worlds) wanted.push_back({world.name(), 30, {}});
  wanted.push_back({"worlds/nobody", 1, {}});

  const std::vector<Result<StepResult>> results = connection.StepWorlds(wanted);

  ASSERT_EQ(results.size(), 4u);
  EXPECT_EQ(RefusalOf(results[3].status())->reason, Reason::kWorldNotFound);
  for (size_t i = 0; i < worlds.size(); ++i) {
    ASSERT_TRUE(results[i].ok()) << results[i].status();
    const Result<StepResult> now = worlds[i].Step(0);
    EXPECT_EQ(results[i]->stamp.step, 30u);
    EXPECT_EQ(results[i]->frame.positions(), now->frame.positions());
  }
}

TEST_P(CppClient, TellsOfWorldsThatDidNotComeWhyTheCallEnded) {
  const Server connection = *Connect(server_.address());
  // A pile that never sleeps takes minutes for all these steps.
  WorldOptions options;
  options.world.default_auto_disable.enabled = false;
  World pile = *MakeWorld(server_, GetParam(), options);
  for (int i = 0; i < 40; ++i) {
    ASSERT_TRUE(pile.Add(Box{{0.5, 0.5, 0.5}}, {.position = {1.1 * (i % 4), 0, 0.5 + i / 4}, .mass = 1}).ok());
  }
  const std::vector<WorldSteps> wanted{{world_.name(), 1, {}}, {pile.name(), 100000, {}}};

  // How long the reply of the first takes on a busy machine is found by trying.
  uint64_t tries = 0;
  for (std::chrono::milliseconds time{300}; time < testing::kPatience; time *= 2) {
    ++tries;
    const std::vector<Result<StepResult>> results = connection.StepWorlds(wanted, time);
    ASSERT_EQ(results.size(), 2u);
    EXPECT_EQ(results[1].status().code(), absl::StatusCode::kDeadlineExceeded);
    if (!results[0].ok()) continue;
    EXPECT_LE(results[0]->stamp.step, tries);
    return;
  }
  FAIL() << "the world that was done did not come";
}

TEST_P(CppClient, DrivesAWorldWithoutWaitingForEachStep) {
  const EntityId ball = *world_.Add(Sphere{}, {.position = {0, 0, 50}, .mass = 1});
  Drive drive = world_.OpenDrive();
  EXPECT_EQ(drive.Receive().status().code(), absl::StatusCode::kFailedPrecondition);
  while (drive.in_flight() < Drive::kInFlightMax) ASSERT_TRUE(drive.Send().ok());
  EXPECT_EQ(drive.Send().code(), absl::StatusCode::kFailedPrecondition);

  double height = 50;
  for (uint64_t step = 1; step <= 200; ++step) {
    const Result<StepResult> result = drive.Receive();
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->stamp.step, step);
    const double now = result->frame.positions()(2, *result->frame.row(ball));
    EXPECT_LT(now, height);
    height = now;
    if (step == 100) {
      ASSERT_TRUE(drive.Send(1, {.expected_step = 7}).ok());
    } else if (step + drive.in_flight() < 200) {
      ASSERT_TRUE(drive.Send().ok());
    }
    if (step + 1 == 100 + Drive::kInFlightMax) {
      EXPECT_EQ(RefusalOf(drive.Receive().status())->reason, Reason::kStepMismatch);
      ASSERT_TRUE(drive.Send().ok());
    }
  }
  EXPECT_EQ(drive.in_flight(), 0u);
}

TEST_P(CppClient, IsToldWhenADriveEnds) {
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(world_.Add(Sphere{}, {.position = {0, 0, 1 + 3.0 * i}, .mass = 1}).ok());
  Drive drive = world_.OpenDrive();
  ASSERT_TRUE(drive.Send(100000).ok());
  EXPECT_EQ(drive.Receive(std::chrono::milliseconds(1)).status().code(), absl::StatusCode::kDeadlineExceeded);

  drive.Cancel();

  EXPECT_EQ(drive.Receive().status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(drive.Send().code(), absl::StatusCode::kCancelled);
}

TEST_P(CppClient, ExplainsAStep) {
  ASSERT_TRUE(world_.Add(Sphere{}, {.position = {0, 0, 0.5}, .mass = 1}).ok());

  const Result<StepResult> result = world_.Step(1, {.stats = true});

  ASSERT_TRUE(result.ok()) << result.status();
  const std::string text = Explain(*result->stats);
  EXPECT_TRUE(text.starts_with("entities: 0 asleep, ")) << text;
  for (const Stats::Stage& stage : result->stats->stages) EXPECT_NE(text.find(stage.name), std::string::npos) << text;
  EXPECT_TRUE(text.ends_with("100.0 %\n")) << text;
}

TEST_P(CppClient, DescribesAnEntityAsItWasAskedFor) {
  const EntityDesc asked = Body(Box{.half_extents = {0.5, 1, 2}}, {.display_name = "crate",
                                                                   .position = {1, 2, 3},
                                                                   .mass = 7,
                                                                   .friction = 0.25,
                                                                   .linear_velocity = {1, 0, 0},
                                                                   .visual = Visual{.uri = "crate.glb"}});
  const Result<EntityId> id = world_.Create(asked);
  ASSERT_TRUE(id.ok()) << id.status();

  const Result<EntityDesc> described = world_.Describe(*id);

  ASSERT_TRUE(described.ok()) << described.status();
  EXPECT_EQ(described->display_name, "crate");
  EXPECT_EQ(described->pose, asked.pose);
  EXPECT_EQ(described->visual, asked.visual);
  EXPECT_EQ(described->rigid_body->geometries[0].shape, asked.rigid_body->geometries[0].shape);
  EXPECT_EQ(described->rigid_body->geometries[0].material.friction, 0.25);
  EXPECT_EQ(described->rigid_body->geometries[0].material.restitution, 0) << "defaults are filled in";
  EXPECT_EQ(described->rigid_body->linear_velocity, Vector3(1, 0, 0));
  const Result<std::vector<EntityInfo>> all = world_.ListEntities();
  ASSERT_TRUE(all.ok()) << all.status();
  ASSERT_EQ(all->size(), 2u) << "the ground and the crate";
  EXPECT_EQ(all->back().id, *id);
}

TEST_P(CppClient, HearsOfACollisionInOrder) {
  Result<EventStream> events = world_.WatchEvents();
  ASSERT_TRUE(events.ok()) << events.status();
  const EntityId ball = *world_.Add(Sphere{}, {.position = {0, 0, 1}, .mass = 1});
  const Result<StepResult> result = world_.Step(240);
  ASSERT_TRUE(result.ok()) << result.status();

  std::vector<Event> heard;
  while (events->position().sequence < result->last_sequence) {
    const Result<std::optional<EventBatch>> batch = events->Next(genphys::testing::kPatience);
    ASSERT_TRUE(batch.ok() && *batch) << batch.status();
    heard.insert(heard.end(), (*batch)->events.begin(), (*batch)->events.end());
  }

  ASSERT_GE(heard.size(), 2u);
  EXPECT_TRUE(std::holds_alternative<EntityCreated>(heard[0].kind));
  ASSERT_TRUE(std::holds_alternative<ContactBegan>(heard[1].kind));
  const ContactBegan& began = std::get<ContactBegan>(heard[1].kind);
  EXPECT_EQ(began.pair.b, ball);
  EXPECT_EQ(began.points.size(), 1u);
  const double fall = std::sqrt(2 * 0.5 / kGravity);
  EXPECT_NEAR(static_cast<double>(heard[1].step) * kStepSize, fall, kStepSize);
  for (size_t i = 1; i < heard.size(); ++i) EXPECT_EQ(heard[i].sequence, heard[i - 1].sequence + 1);
}

TEST_P(CppClient, GoesOnListeningWhereItStopped) {
  StreamPosition position;
  {
    Result<EventStream> events = world_.WatchEvents();
    ASSERT_TRUE(events.ok()) << events.status();
    position = events->position();
  }
  const EntityId missed = *world_.Create({.display_name = "missed"});

  Result<EventStream> events = world_.WatchEvents({.after = position});
  ASSERT_TRUE(events.ok()) << events.status();
  Result<std::optional<EventBatch>> batch = events->Next(genphys::testing::kPatience);
  while (batch.ok() && *batch && (*batch)->events.empty()) batch = events->Next(genphys::testing::kPatience);

  ASSERT_TRUE(batch.ok() && *batch) << batch.status();
  EXPECT_EQ(std::get<EntityCreated>((*batch)->events[0].kind).id, missed);
}

TEST_P(CppClient, SeesFramesWhileTheWorldPlays) {
  const EntityId ball = *world_.Add(Sphere{}, {.position = {0, 0, 1000}, .mass = 1});
  Result<FrameStream> frames = world_.WatchFrames({}, 4);
  ASSERT_TRUE(frames.ok()) << frames.status();
  const Result<std::optional<Frame>> first = frames->Next(genphys::testing::kPatience);
  ASSERT_TRUE(first.ok() && *first) << first.status();
  EXPECT_EQ((*first)->stamp().step, 0u);

  ASSERT_TRUE(world_.Play().ok());
  const Result<std::optional<Frame>> later = frames->Next(genphys::testing::kPatience);
  ASSERT_TRUE(world_.Pause().ok());

  ASSERT_TRUE(later.ok() && *later) << later.status();
  EXPECT_GT((*later)->stamp().step, 0u);
  EXPECT_EQ((*later)->stamp().step % 4, 0u);
  EXPECT_LT((*later)->positions()(2, *(*later)->row(ball)), 1000);
}

TEST_P(CppClient, FindsWhatARayHits) {
  const EntityId ball = *world_.Add(Sphere{.radius = 0.5}, {.position = {0, 0, 5}, .mass = 1});

  const Result<std::vector<RayHit>> hits =
      world_.CastRays(std::vector<Ray>{{{-2, 0, 5}, {4, 0, 0}}, {{-2, 3, 5}, {4, 0, 0}}});

  ASSERT_TRUE(hits.ok()) << hits.status();
  ASSERT_EQ(hits->size(), 2u);
  constexpr double kRounding = 1e-9;
  EXPECT_EQ((*hits)[0].entity, ball);
  EXPECT_NEAR((*hits)[0].fraction, 1.5 / 4, kRounding);
  EXPECT_TRUE((*hits)[0].normal.isApprox(-Vector3::UnitX(), kRounding));
  EXPECT_TRUE((*hits)[1].entity.is_null());
}

TEST_P(CppClient, AsksWhatShapesMeetAndOverlapAndHowFarThingsAre) {
  constexpr double kExact = 1e-9;  // m: the narrow phase's
  const EntityId ball = *world_.Add(Sphere{.radius = 0.5}, {.position = {0, 0, 5}, .mass = 1});
  const EntityId cone = *world_.Add(Cone{.radius = 0.5, .half_length = 0.5}, {.position = {3, 0, 5}, .mass = 1});
  const std::vector<Pose> places{{{-2, 0, 5}}};
  const std::vector<Vector3> ways{{4, 0, 0}};

  const auto through = world_.CastRaysThrough(std::vector<Ray>{{{-2, 0, 5}, {8, 0, 0}}});
  ASSERT_TRUE(through.ok()) << through.status();
  ASSERT_EQ((*through)[0].size(), 2u);
  EXPECT_EQ((*through)[0][1].hit, (GeometryId{cone, 1}));
  const auto hits = world_.CastShape(Sphere{0.25}, places, ways);
  ASSERT_TRUE(hits.ok()) << hits.status();
  EXPECT_EQ((*hits)[0].hit, (GeometryId{ball, 1}));
  EXPECT_NEAR((*hits)[0].fraction, 1.25 / 4, kExact);
  const auto overlaps = world_.FindOverlaps(Sphere{1.6}, places);
  ASSERT_TRUE(overlaps.ok()) << overlaps.status();
  EXPECT_EQ((*overlaps)[0], (std::vector<GeometryId>{{ball, 1}}));
  const auto closest = world_.FindClosest(Sphere{0.25}, places, 10);
  ASSERT_TRUE(closest.ok()) << closest.status();
  EXPECT_NEAR((*closest)[0].distance, 1.25, kExact);
  const auto distances = world_.MeasureDistances(std::vector<EntityId>{ball}, std::vector<EntityId>{cone});
  ASSERT_TRUE(distances.ok()) << distances.status();
  EXPECT_NEAR((*distances)[0].distance, std::hypot(2.5, 0.5) - 0.5, kExact) << "to the rim of the cone";
  const auto contacts = world_.ContactsOf(ball);
  ASSERT_TRUE(contacts.ok()) << contacts.status();
  EXPECT_TRUE(contacts->empty());
}

TEST_P(CppClient, MovesToNoEngineAndBack) {
  const EntityId ball = *world_.Add(Sphere{}, {.position = {0, 0, 5}, .mass = 1, .linear_velocity = {1, 0, 0}});

  ASSERT_TRUE(world_.SetEngine("none").ok());
  const Result<StepResult> frozen = world_.Step(10);
  ASSERT_TRUE(world_.SetEngine(GetParam()).ok());
  const Result<StepResult> moving = world_.Step(10);

  ASSERT_TRUE(frozen.ok() && moving.ok()) << frozen.status() << moving.status();
  EXPECT_EQ(frozen->frame.pose(*frozen->frame.row(ball)).position, Vector3(0, 0, 5));
  EXPECT_GT(moving->frame.positions()(0, *moving->frame.row(ball)), 0);
  EXPECT_EQ(world_.Info()->world.engine, GetParam());
}

TEST_P(CppClient, ReadsWhatJointsDoAsColumnsOfAFrame) {
  const EntityId ball = *world_.Add(Sphere{.radius = 0.1}, {.position = {0, 0, 5}, .mass = 1});
  const EntityId other = *world_.Add(Sphere{.radius = 0.1}, {.position = {3, 0, 5}, .mass = 2});
  const JointId turning =
      *world_.Join({.entity_b = {ball, {}}, .kind = HingeJoint{.axis = {.motor = Motor{.target_velocity = 3}}}});
  const JointId fixed = *world_.Join({.entity_b = {other, {}}, .kind = FixedJoint{}});

  const Result<StepResult> result = world_.Step(240, {.frame = FrameOptions{.joints = true}});

  ASSERT_TRUE(result.ok()) << result.status();
  const Frame& frame = result->frame;
  ASSERT_EQ(frame.joint_ids().size(), 2u);
  // What joints hold is solved all at once.
  constexpr double kDirect = 1e-4;
  EXPECT_NEAR(frame.joint_rates()(5, *frame.joint_column(turning)), 3, 3 * kDirect);
  EXPECT_NEAR(frame.joint_positions()(5, *frame.joint_column(turning)), 3, 3 * kDirect);
  EXPECT_NEAR(frame.joint_forces()(2, *frame.joint_column(fixed)), 2 * kGravity, 2 * kGravity * kDirect);
  EXPECT_FALSE(frame.joint_column(JointId(9, 9)).has_value());
  EXPECT_TRUE(world_.Step(1)->frame.joint_ids().empty()) << "nobody asked";
}

TEST_P(CppClient, ChangesEntitiesAndForceFields) {
  const EntityId ball = *world_.Add(Sphere{}, {.position = {0, 0, 5}, .mass = 1});
  const Result<ForceFieldId> field = world_.AddField({.kind = DragField{.linear = 1}, .entities = {ball}});
  ASSERT_TRUE(field.ok()) << field.status();
  ASSERT_TRUE(world_.UpdateField(*field, {.kind = DragField{.linear = 2}}).ok());
  const Result<std::vector<ForceFieldInfo>> fields = world_.ListForceFields();
  ASSERT_TRUE(fields.ok()) << fields.status();
  ASSERT_EQ(fields->size(), 1u);
  EXPECT_EQ(fields->front().id, *field);
  EXPECT_EQ(std::get<DragField>(fields->front().field.kind).linear, 2);
  EXPECT_TRUE(fields->front().field.entities.empty());

  const EntityDesc still = Body(Sphere{}, {.motion_type = MotionType::kStatic});
  EntityFields part;
  part.Add(EntityField::kMotionType);
  ASSERT_TRUE(world_.Update(ball, still, part).ok());
  EXPECT_EQ(world_.Describe(ball)->rigid_body->motion_type, MotionType::kStatic);
  const Result<StepResult> result = world_.Step(0, {.commands = {DeleteForceField{*field}}});
  ASSERT_EQ(result->events.size(), 1u);
  EXPECT_EQ(std::get<ForceFieldDeleted>(result->events[0].kind).field, *field);
}

TEST_P(CppClient, LearnsWhyACommandWasRefused) {
  const Result<EntityId> refused = world_.Add(Sphere{.radius = -1}, {.position = {0, 0, 5}, .mass = 1});
  ASSERT_TRUE(RefusalOf(refused.status()).has_value()) << refused.status();
  EXPECT_EQ(RefusalOf(refused.status())->reason, Reason::kOutOfRange);
  EXPECT_EQ(RefusalOf(refused.status())->field, "entity.rigid_body.geometries[0].shape.sphere.radius");

  const EntityId gone = *world_.Create({});
  ASSERT_TRUE(world_.Remove(gone).ok());
  EXPECT_EQ(RefusalOf(world_.SetPose({.id = gone, .position = Vector3(1, 2, 3)}))->reason, Reason::kStaleId);
  EXPECT_EQ(RefusalOf(world_.SetEngine("steam"))->reason, Reason::kInvalidValue);
  EXPECT_EQ(RefusalOf(world_.Step(1, {.expected_step = 9}).status())->reason, Reason::kStepMismatch);
}

TEST_P(CppClient, TellsItsListenersWhenTheWorldIsGone) {
  Result<EventStream> events = world_.WatchEvents();
  ASSERT_TRUE(events.ok()) << events.status();
  EXPECT_TRUE(world_.Delete().ok());

  Result<std::optional<EventBatch>> last = events->Next(genphys::testing::kPatience);
  while (last.ok() && *last) last = events->Next(genphys::testing::kPatience);

  EXPECT_TRUE(last.ok()) << last.status();
  EXPECT_EQ(RefusalOf(world_.Step().status())->reason, Reason::kWorldNotFound);
}

TEST(CppClientServer, KnowsItsEngines) {
  TestServer server;

  const Result<std::vector<EngineInfo>> engines = Connect(server.address())->ListEngines();

  ASSERT_TRUE(engines.ok()) << engines.status();
  EXPECT_EQ(engines->size(), genphys::testing::Engines().backends().size());
  for (const EngineInfo& info : *engines) {
    const Backend* backend = genphys::testing::Engines().Find(info.engine);
    ASSERT_NE(backend, nullptr) << info.engine;
    EXPECT_EQ(info.version, backend->capabilities().version());
    for (const Feature feature : info.features) EXPECT_TRUE(backend->capabilities().Has(feature)) << NameOf(feature);
  }
}

TEST(CppClientServer, KnowsItsWorlds) {
  TestServer server;
  const Result<Server> connected = Connect(server.address());
  ASSERT_TRUE(connected.ok()) << connected.status();

  {
    Result<World> made = connected->CreateWorld({.name = "demo", .record_state_hash = true});
    ASSERT_TRUE(made.ok()) << made.status();
    EXPECT_EQ(*connected->ListWorlds(), std::vector<std::string>{"worlds/demo"});
    const Result<World> opened = connected->OpenWorld("demo");
    ASSERT_TRUE(opened.ok()) << opened.status();
    EXPECT_TRUE(opened->Info()->stamp.state_hash.has_value());
    EXPECT_EQ(RefusalOf(connected->CreateWorld({.name = "demo"}).status())->reason, Reason::kAlreadyExists);
  }

  EXPECT_TRUE(connected->ListWorlds()->empty());
  EXPECT_EQ(RefusalOf(connected->OpenWorld("demo").status())->reason, Reason::kWorldNotFound);
}

}  // namespace
}  // namespace genphys::client

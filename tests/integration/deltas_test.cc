// Frames as deltas: whatever happens, what is laid over the keyframe is the world as it is.
#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "conformance/engine_test.h"
#include "integration/live_server.h"

namespace genphys::testing {
namespace {

using Simulation = v1::SimulationService::Stub;

constexpr client::FrameOptions kWhole{.net_forces = true};
constexpr client::FrameOptions kDeltas{.net_forces = true, .deltas = true};

void ExpectSame(const client::Frame& merged, const client::Frame& whole, const std::string& whose) {
  ASSERT_EQ(std::vector<EntityId>(merged.ids().begin(), merged.ids().end()),
            std::vector<EntityId>(whole.ids().begin(), whole.ids().end()))
      << whose;
  EXPECT_EQ(merged.stamp().step, whole.stamp().step) << whose;
  EXPECT_EQ(merged.positions(), whole.positions()) << whose;
  EXPECT_EQ(merged.orientations(), whole.orientations()) << whose;
  EXPECT_EQ(merged.linear_velocities(), whole.linear_velocities()) << whose;
  EXPECT_EQ(merged.angular_velocities(), whole.angular_velocities()) << whose;
  EXPECT_EQ(merged.net_forces(), whole.net_forces()) << whose;
  for (uint32_t row = 0; row < whole.rows(); ++row) EXPECT_EQ(merged.asleep(row), whole.asleep(row)) << whose;
}

class Deltas : public EngineTest {};

INSTANTIATE_TEST_SUITE_P(Engines, Deltas, ::testing::ValuesIn(EnginesWithContacts()), EngineName);

// A change that may move, wake, add or remove something, or the whole world.
Command RandomChange(std::mt19937& random, std::vector<EntityId>& bodies, const std::string& engine) {
  const EntityId some = bodies[random() % bodies.size()];
  const auto metres = [&](double range) { return range * (static_cast<double>(random()) / 4294967295.0 - 0.5); };
  switch (random() % 9) {
    case 0:
      return SetPose{.id = some, .position = Vector3(metres(20), metres(20), 2)};
    case 1:
      return SetVelocity{.id = some, .linear = Vector3(metres(4), metres(4), 3)};
    case 2:
      return ApplyForce{.id = some, .force = Vector3(metres(50), 0, 20), .steps = 3};
    case 3:
      return ApplyForceColumns{.ids = {some}, .forces = {Vector3(0, metres(50), 20)}};
    case 4:
      return CreateEntity{client::Body(Sphere{.radius = 0.3}, {.position = {metres(20), metres(20), 3}, .mass = 1})};
    case 5:
      if (bodies.size() < 10) return SetGravity{Vector3(0, 0, -9)};
      std::erase(bodies, some);
      return DeleteEntity{some};
    case 6:
      return SetGravity{Vector3(metres(1), 0, -9.81)};
    case 7:
      return SetEngine{engine};
    default:
      return ApplyImpulse{.id = some, .linear = Vector3(0, 0, 1)};
  }
}

TEST_P(Deltas, AreTheWorldOnceLaidOverTheirKeyframe) {
  constexpr int kBodies = 30;
  constexpr int kRounds = 400;
  LiveServer server;
  client::World world = Value(server.Connect().CreateWorld(WorldOn(GetParam())));
  std::vector<EntityId> bodies;
  for (int i = 0; i < kBodies; ++i) {
    const MotionType motion = i % 6 == 0 ? MotionType::kStatic : MotionType::kDynamic;
    bodies.push_back(Value(world.Add(
        Box{{0.4, 0.4, 0.4}}, {.position = {1.5 * (i % 6), 1.5 * (i / 6), 0.4}, .mass = 1, .motion_type = motion})));
  }
  MustBeOk(world.Step(200).status());
  client::FrameStream pushed = Value(world.WatchFrames(kDeltas));
  client::Frame seen = *Value(pushed.Next());
  client::Drive drive = world.OpenDrive();
  std::mt19937 random(7);

  for (int round = 0; round < kRounds && !HasFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    client::StepOptions options{.frame = kDeltas};
    std::vector<Command> changes;
    if (random() % 8 == 0) changes.push_back(RandomChange(random, bodies, GetParam()));
    const bool refusable = !changes.empty();
    options.commands = changes;
    const auto steps = static_cast<uint32_t>(random() % 3);
    const Result<client::StepResult> stepped = world.Step(steps, options);
    // A pose in another body, or an impulse on a fixture, may be refused: then nothing has changed.
    if (!stepped.ok()) {
      ASSERT_TRUE(refusable && RefusalOf(stepped.status())) << stepped.status();
      continue;
    }
    for (const CreatedId id : stepped->created) {
      if (!id.is_null()) bodies.push_back(id);
    }
    const client::Frame whole = Value(world.Step(0, {.frame = kWhole})).frame;
    ExpectSame(stepped->frame, whole, "stepper");
    MustBeOk(drive.Send(0, {.frame = kDeltas}));
    ExpectSame(Value(drive.Receive()).frame, whole, "driver");
    // The viewer may be late, and sees the newest then.
    while (seen.stamp().step < whole.stamp().step) seen = *Value(pushed.Next());
    if (steps > 0) ExpectSame(seen, whole, "viewer");
    if (round % 50 == 49) ExpectSame(*Value(Value(world.WatchFrames(kDeltas)).Next()), whole, "newcomer");
  }
  EXPECT_GT(bodies.size(), 5u);
}

v1::StepRequest DeltaStep(const std::string& world) {
  v1::StepRequest request;
  request.set_world(world);
  request.mutable_frame()->set_poses(true);
  request.mutable_frame()->set_deltas(true);
  return request;
}

class DeltaFrames : public ::testing::Test {
 protected:
  DeltaFrames() {
    world_ = server_.CreateWorld().world().name();
    for (int i = 0; i < 8; ++i) balls_.push_back(server_.AddBall(world_, 1.0 + 2 * i));
    v1::StepRequest request;
    request.set_world(world_);
    request.set_steps(0);
    request.add_commands()->mutable_set_gravity()->mutable_gravity();
    Must(server_.simulation(), &Simulation::Step, request);
  }
  v1::Frame Step(v1::StepRequest request) { return Must(server_.simulation(), &Simulation::Step, request).frame(); }
  void Kick(uint64_t ball) {
    v1::StepRequest request;
    request.set_world(world_);
    request.set_steps(0);
    v1::SetVelocity& velocity = *request.add_commands()->mutable_set_velocity();
    velocity.set_entity_id(ball);
    velocity.mutable_linear()->set_x(1);
    Must(server_.simulation(), &Simulation::Step, request);
  }

  TestServer server_;
  std::string world_;
  std::vector<uint64_t> balls_;
};

TEST_F(DeltaFrames, HaveNoRowsOfWhatStaysAsItWas) {
  v1::StepRequest request = DeltaStep(world_);
  const v1::Frame keyframe = Step(request);
  EXPECT_FALSE(keyframe.has_keyframe_step());
  ASSERT_NE(keyframe.keyframe_id(), 0u);
  request.mutable_frame()->set_keyframe_id(keyframe.keyframe_id());

  const v1::Frame still = Step(request);
  Kick(balls_[3]);
  const v1::Frame moved = Step(request);

  EXPECT_EQ(still.keyframe_step(), keyframe.stamp().step());
  EXPECT_EQ(still.keyframe_id(), keyframe.keyframe_id());
  EXPECT_EQ(still.entity_ids() + still.positions() + still.orientations() + still.asleep(), "");
  ASSERT_EQ(moved.entity_ids().size(), sizeof(uint64_t));
  EXPECT_EQ(std::memcmp(moved.entity_ids().data(), &balls_[3], sizeof(uint64_t)), 0);
  EXPECT_EQ(moved.positions().size(), 3 * sizeof(double));
}

TEST_F(DeltaFrames, AreWholeForAKeyframeThatTheServerDoesNotKnow) {
  v1::StepRequest request = DeltaStep(world_);
  const v1::Frame keyframe = Step(request);
  v1::StepRequest forged = request, others = request;
  forged.mutable_frame()->set_keyframe_id(keyframe.keyframe_id() + 1000);
  others.mutable_frame()->set_keyframe_id(keyframe.keyframe_id());
  others.mutable_frame()->set_velocities(true);

  EXPECT_FALSE(Step(forged).has_keyframe_step());
  EXPECT_FALSE(Step(others).has_keyframe_step()) << "it has other columns";

  v1::ResetWorldRequest reset;
  reset.set_name(world_);
  Must(server_.worlds(), &v1::WorldService::Stub::ResetWorld, reset);
  request.mutable_frame()->set_keyframe_id(keyframe.keyframe_id());
  EXPECT_FALSE(Step(request).has_keyframe_step()) << "it is of another epoch";
}

TEST_F(DeltaFrames, AreWholeWhenTooMuchIsOtherOrSomebodyCame) {
  v1::StepRequest request = DeltaStep(world_);
  const v1::Frame keyframe = Step(request);
  request.mutable_frame()->set_keyframe_id(keyframe.keyframe_id());
  // Of nine rows four may differ.
  for (int i = 0; i < 4; ++i) Kick(balls_[static_cast<size_t>(i)]);
  EXPECT_TRUE(Step(request).has_keyframe_step());
  Kick(balls_[4]);
  EXPECT_FALSE(Step(request).has_keyframe_step());

  request.mutable_frame()->clear_keyframe_id();
  request.mutable_frame()->set_keyframe_id(Step(request).keyframe_id());
  server_.AddBall(world_, 30);
  EXPECT_FALSE(Step(request).has_keyframe_step());
}

TEST_F(DeltaFrames, AreSentToViewersAfterOneWholeFrame) {
  v1::WatchFramesRequest request;
  request.set_world(world_);
  *request.mutable_frame() = DeltaStep(world_).frame();
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
  const auto reader = server_.simulation().WatchFrames(&context, request);
  v1::WatchFramesResponse first, still;

  ASSERT_TRUE(reader->Read(&first));
  server_.Step(world_);
  ASSERT_TRUE(reader->Read(&still));

  EXPECT_FALSE(first.frame().has_keyframe_step());
  EXPECT_EQ(still.frame().keyframe_id(), first.frame().keyframe_id());
  EXPECT_EQ(still.frame().entity_ids().size(), 0u);
  EXPECT_EQ(still.frame().stamp().step(), first.frame().stamp().step() + 1);
  context.TryCancel();
  reader->Finish();
}

}  // namespace
}  // namespace genphys::testing

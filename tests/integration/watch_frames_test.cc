// Streams of frames as a viewer sees them.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "support/test_server.h"

namespace genphys::testing {
namespace {

using Response = v1::WatchFramesResponse;

class View {
 public:
  View(TestServer& server, const v1::WatchFramesRequest& request) {
    context_.set_deadline(std::chrono::system_clock::now() + kPatience);
    reader_ = server.simulation().WatchFrames(&context_, request);
  }
  ~View() {
    context_.TryCancel();
    if (!ended_) reader_->Finish();
  }
  std::optional<v1::Frame> Read() {
    Response response;
    if (!reader_->Read(&response)) return std::nullopt;
    return response.frame();
  }
  v1::Frame Next() {
    std::optional<v1::Frame> frame = Read();
    EXPECT_TRUE(frame) << "the stream has ended";
    return frame.value_or(v1::Frame());
  }
  Status Finish() {
    ended_ = true;
    return Received(reader_->Finish());
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<Response>> reader_;
  bool ended_ = false;
};

v1::WatchFramesRequest RequestFor(const std::string& world) {
  v1::WatchFramesRequest request;
  request.set_world(world);
  return request;
}

TEST(WatchFrames, ShowsThePosesOfThePresentAtOnce) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  server.AddBall(world, 3);
  server.Step(world, 7);

  const v1::Frame frame = View(server, RequestFor(world)).Next();

  EXPECT_EQ(frame.stamp().step(), 7u);
  EXPECT_EQ(frame.positions().size(), 2 * 3 * sizeof(double));
  EXPECT_EQ(frame.skipped_frames(), 0u);
}

TEST(WatchFrames, ShowsEveryStepToWhoeverKeepsUp) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  View view(server, RequestFor(world));
  view.Next();

  for (uint64_t step = 1; step <= 5; ++step) {
    server.Step(world);
    const v1::Frame frame = view.Next();
    EXPECT_EQ(frame.stamp().step(), step);
    EXPECT_EQ(frame.skipped_frames(), 0u);
  }
}

TEST(WatchFrames, ShowsAChangeBetweenSteps) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  View view(server, RequestFor(world));
  EXPECT_EQ(view.Next().positions().size(), 3 * sizeof(double));

  server.AddBall(world, 3);

  const v1::Frame frame = view.Next();
  EXPECT_EQ(frame.stamp().step(), 0u);
  EXPECT_EQ(frame.positions().size(), 2 * 3 * sizeof(double));
}

TEST(WatchFrames, LeavesOutStepsWhenAsked) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::WatchFramesRequest request = RequestFor(world);
  request.set_every_nth_step(4);
  View view(server, request);
  EXPECT_EQ(view.Next().stamp().step(), 0u);

  for (uint64_t step = 4; step <= 12; step += 4) {
    server.Step(world, 4);
    EXPECT_EQ(view.Next().stamp().step(), step);
  }
}

TEST(WatchFrames, GivesALateViewerTheNewestAndCountsTheRest) {
  // A stretch of steps during which one viewer reads nothing: more bytes than gRPC takes on its own.
  constexpr int kEntities = 20000;
  constexpr uint32_t kSteps = 200;
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(0);
  for (int i = 0; i < kEntities; ++i) request.add_commands()->mutable_create_entity()->mutable_entity();
  Must(server.simulation(), &v1::SimulationService::Stub::Step, request);
  View view(server, RequestFor(world));
  const v1::Frame first = view.Next();

  for (uint32_t i = 0; i < kSteps; ++i) server.Step(world);

  uint64_t seen = 0, skipped = 0;
  for (uint64_t step = first.stamp().step(); step < kSteps;) {
    const v1::Frame frame = view.Next();
    ASSERT_GT(frame.stamp().step(), step);
    EXPECT_EQ(frame.skipped_frames(), frame.stamp().step() - step - 1);
    step = frame.stamp().step();
    skipped += frame.skipped_frames();
    ++seen;
  }
  EXPECT_EQ(seen + skipped, kSteps);
  EXPECT_GT(skipped, 0u);
}

TEST(WatchFrames, ShowsViewersWithDifferentWishesWhatEachWants) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  const uint64_t ball = server.AddBall(world, 3);
  v1::WatchFramesRequest one_ball = RequestFor(world);
  one_ball.mutable_frame()->set_velocities(true);
  one_ball.mutable_frame()->set_scalar(v1::SCALAR_FLOAT32);
  one_ball.mutable_frame()->add_entity_ids(ball);
  View all_poses(server, RequestFor(world)), also_poses(server, RequestFor(world)), velocities(server, one_ball);
  all_poses.Next();
  also_poses.Next();
  velocities.Next();

  server.Step(world);
  const v1::Frame a = all_poses.Next(), b = also_poses.Next(), c = velocities.Next();

  EXPECT_EQ(a.SerializeAsString(), b.SerializeAsString());
  EXPECT_EQ(a.positions().size(), 2 * 3 * sizeof(double));
  EXPECT_TRUE(c.positions().empty());
  EXPECT_EQ(c.linear_velocities().size(), 3 * sizeof(float));
}

TEST(WatchFrames, RefusesEntitiesThatNeverWereAndLeavesOutThoseThatGo) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  const uint64_t gone = server.AddBall(world, 3), going = server.AddBall(world, 6), ball = server.AddBall(world, 9);
  const auto remove = [&](uint64_t id) {
    v1::DeleteEntityRequest request;
    request.set_world(world);
    request.set_entity_id(id);
    Must(server.simulation(), &v1::SimulationService::Stub::DeleteEntity, request);
  };
  remove(gone);
  v1::WatchFramesRequest request = RequestFor(world);
  for (const uint64_t id : {gone, going, ball}) request.mutable_frame()->add_entity_ids(id);
  View view(server, request);
  EXPECT_EQ(view.Next().entity_ids().size(), 2 * sizeof(uint64_t));

  remove(going);
  EXPECT_EQ(view.Next().entity_ids().size(), sizeof(uint64_t));

  request.mutable_frame()->add_entity_ids(ball + 7);
  View refused(server, request);
  EXPECT_FALSE(refused.Read());
  ExpectRefusal(refused.Finish(), Reason::kEntityNotFound, "frame.entity_ids[3]");
  server.Step(world);
  EXPECT_EQ(view.Next().entity_ids().size(), sizeof(uint64_t)) << "the other stream goes on";
}

TEST(WatchFrames, RefusesBadRequestsAndEndsWithItsWorld) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::WatchFramesRequest bad = RequestFor(world);
  bad.set_every_nth_step(0);
  View refused(server, bad);
  EXPECT_FALSE(refused.Read());
  ExpectRefusal(refused.Finish(), Reason::kOutOfRange, "every_nth_step");
  View view(server, RequestFor(world));
  view.Next();

  v1::DeleteWorldRequest request;
  request.set_name(world);
  Must(server.worlds(), &v1::WorldService::Stub::DeleteWorld, request);

  EXPECT_FALSE(view.Read());
  EXPECT_TRUE(view.Finish().ok());
}

}  // namespace
}  // namespace genphys::testing

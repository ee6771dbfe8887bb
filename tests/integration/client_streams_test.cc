// Streams of the C++ client: what a slow viewer sees, and how they outlive their server.
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "genphys/v1/simulation_service.grpc.pb.h"
#include "genphys/v1/world_service.grpc.pb.h"
#include "integration/live_server.h"

namespace genphys::testing {
namespace {

class ClientFrameStream : public ::testing::TestWithParam<bool> {};

TEST_P(ClientFrameStream, HasTheNewestForAViewerThatWasBusyAndCountsTheRest) {
  // Far less than what fits into the windows of a connection.
  constexpr uint64_t kSteps = 50;
  constexpr std::chrono::milliseconds kLook(10);
  const LiveServer live;
  client::World world = Value(live.Connect().CreateWorld({}));
  for (int i = 0; i < 20; ++i) Value(world.Add(Sphere{0.1}, {.position = {double(i), 0, 5}, .mass = 1}));
  client::FrameStream frames = Value(world.WatchFrames({.deltas = GetParam()}));
  client::Frame seen = *Value(frames.Next());

  for (uint64_t round = 1; round <= 3; ++round) {
    client::Frame stepped;
    for (uint64_t i = 0; i < kSteps; ++i) stepped = Value(world.Step()).frame;
    // Until they are there.
    std::this_thread::sleep_for(50 * kLook);
    const client::Frame newest = *Value(frames.Next());

    EXPECT_EQ(newest.stamp().step, round * kSteps);
    EXPECT_EQ(newest.skipped_frames(), newest.stamp().step - seen.stamp().step - 1);
    EXPECT_EQ(newest.positions(), stepped.positions());
    seen = newest;
  }
}

INSTANTIATE_TEST_SUITE_P(WholeAndDeltas, ClientFrameStream, ::testing::Bool());

// What a server does to calls that reach it in its last moments.
class Leaving final : public v1::SimulationService::Service {
 public:
  grpc::Status WatchEvents(grpc::ServerContext*, const v1::WatchEventsRequest*,
                           grpc::ServerWriter<v1::WatchEventsResponse>* writer) override {
    if (++calls_ % 2 == 0) return grpc::Status(grpc::StatusCode::CANCELLED, "");
    v1::WatchEventsResponse response;
    response.mutable_batch()->set_last_sequence(calls_);
    if (calls_ > 1) response.mutable_gap()->set_last_sequence(calls_);
    writer->Write(response);
    return calls_ > 3 ? grpc::Status::OK : grpc::Status(grpc::StatusCode::CANCELLED, "");
  }

  int calls() const { return calls_; }

 private:
  std::atomic<int> calls_ = 0;
};

class OneWorld final : public v1::WorldService::Service {
 public:
  grpc::Status GetWorld(grpc::ServerContext*, const v1::GetWorldRequest* request,
                        v1::GetWorldResponse* response) override {
    if (++calls_ == 1) return grpc::Status(grpc::StatusCode::CANCELLED, "");
    response->mutable_world()->set_name(request->name());
    response->mutable_world()->set_engine("engines/ode");
    return grpc::Status::OK;
  }

 private:
  std::atomic<int> calls_ = 0;
};

TEST(ClientStreams, ComeBackWhenTheServerCancelsThemAsItGoes) {
  Leaving simulation;
  OneWorld worlds;
  TemporaryFolder folder;
  const std::string address = "unix:" + (folder.path() / "s").string();
  grpc::ServerBuilder builder;
  builder.AddListeningPort(address, grpc::InsecureServerCredentials());
  builder.RegisterService(&simulation);
  builder.RegisterService(&worlds);
  const std::unique_ptr<grpc::Server> fake = builder.BuildAndStart();
  client::Server server = Value(client::Connect(address));
  client::World world = Value(server.OpenWorld("lab"));
  world.Keep();

  client::EventStream events = Value(world.WatchEvents({}));
  const Result<std::optional<client::EventBatch>> batch = events.Next(kPatience);

  ASSERT_TRUE(batch.ok() && *batch) << batch.status();
  EXPECT_EQ((*batch)->gap->last_sequence, 3u);
  EXPECT_EQ(simulation.calls(), 3);
}

}  // namespace
}  // namespace genphys::testing

// Drive: steps without waiting for each reply.
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <thread>

#include "genphys/hosting/drive.h"
#include "genphys/wire/error.h"
#include "support/test_server.h"

namespace genphys::testing {
namespace {

using Simulation = v1::SimulationService::Stub;
using google::protobuf::util::MessageDifferencer;

class Driver {
 public:
  explicit Driver(TestServer& server) {
    context_.set_deadline(std::chrono::system_clock::now() + kPatience);
    stream_ = server.simulation().Drive(&context_);
  }
  ~Driver() {
    context_.TryCancel();
    if (!finished_) stream_->Finish();
  }

  bool Send(const v1::StepRequest& step) {
    v1::DriveRequest request;
    *request.mutable_step() = step;
    return stream_->Write(request);
  }
  bool Send(const v1::DriveRequest& request) { return stream_->Write(request); }
  std::optional<v1::DriveResponse> Read() {
    v1::DriveResponse response;
    if (!stream_->Read(&response)) return std::nullopt;
    return response;
  }
  v1::DriveResponse Next() {
    const std::optional<v1::DriveResponse> response = Read();
    EXPECT_TRUE(response) << "the stream has ended";
    return response.value_or(v1::DriveResponse());
  }
  Status NextRefusal() {
    const v1::DriveResponse response = Next();
    EXPECT_TRUE(response.has_refusal());
    return DecodeRefusal(response.refusal());
  }
  void CloseInput() { stream_->WritesDone(); }
  void Cancel() { context_.TryCancel(); }
  Status Finish() {
    finished_ = true;
    return Received(stream_->Finish());
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::DriveRequest, v1::DriveResponse>> stream_;
  bool finished_ = false;
};

v1::StepRequest StepOf(const std::string& world, uint32_t steps = 1) {
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(steps);
  request.mutable_frame()->set_poses(true);
  request.mutable_events();
  return request;
}

uint64_t StepAtRest(TestServer& server, const std::string& world) { return server.Step(world, 0).stamp().step(); }

TEST(Drive, AnswersInOrderWhatStepWouldHave) {
  constexpr int kRequests = 200;
  constexpr int kAhead = 8;
  TestServer server;
  const std::string driven = server.CreateWorld().world().name(), stepped = server.CreateWorld().world().name();
  server.AddBall(driven, 0.6);
  server.AddBall(stepped, 0.6);
  Driver driver(server);

  for (int i = 0; i < kAhead; ++i) EXPECT_TRUE(driver.Send(StepOf(driven)));
  for (int i = 0; i < kRequests; ++i) {
    v1::StepResponse reply = driver.Next().response();
    v1::StepResponse alone = Must(server.simulation(), &Simulation::Step, StepOf(stepped));
    EXPECT_EQ(reply.stamp().step(), static_cast<uint64_t>(i) + 1);
    for (v1::StepResponse* each : {&reply, &alone}) {
      each->mutable_stamp()->clear_epoch();
      each->mutable_frame()->mutable_stamp()->clear_epoch();
    }
    EXPECT_TRUE(MessageDifferencer::Equals(reply, alone)) << "step " << i;
    if (i + kAhead < kRequests) driver.Send(StepOf(driven));
  }
  driver.CloseInput();

  EXPECT_FALSE(driver.Read());
  EXPECT_TRUE(driver.Finish().ok());
}

TEST(Drive, AnswersARefusalInItsPlaceAndGoesOn) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  Driver driver(server);
  v1::StepRequest wrong = StepOf(world), late = StepOf(world), nobody = StepOf("worlds/nobody");
  wrong.add_commands()->mutable_apply_force()->set_entity_id(12345);
  late.set_expected_step(1);

  driver.Send(StepOf(world));
  driver.Send(wrong);
  driver.Send(v1::DriveRequest());
  driver.Send(StepOf(world));
  driver.Send(late);
  driver.Send(nobody);
  driver.Send(StepOf(world));
  driver.CloseInput();

  EXPECT_EQ(driver.Next().response().stamp().step(), 1u);
  ExpectRefusal(driver.NextRefusal(), Reason::kEntityNotFound, "commands[0].apply_force.entity_id");
  ExpectRefusal(driver.NextRefusal(), Reason::kMissingField, "step");
  EXPECT_EQ(driver.Next().response().stamp().step(), 2u);
  ExpectRefusal(driver.NextRefusal(), Reason::kStepMismatch, "expected_step");
  ExpectRefusal(driver.NextRefusal(), Reason::kWorldNotFound, "world");
  EXPECT_EQ(driver.Next().response().stamp().step(), 3u);
  EXPECT_FALSE(driver.Read());
  EXPECT_TRUE(driver.Finish().ok());
}

TEST(Drive, RefusesWhatWaitsForAWorldThatIsDeletedMeanwhile) {
  constexpr uint32_t kMany = 100000;
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  for (int i = 0; i < 10; ++i) server.AddBall(world, 1 + i);
  Driver driver(server);
  driver.Send(StepOf(world, kMany));
  driver.Send(StepOf(world));
  v1::GetWorldRequest get;
  get.set_name(world);
  while (Must(server.worlds(), &v1::WorldService::Stub::GetWorld, get).stamp().step() == 0) {
  }

  v1::DeleteWorldRequest request;
  request.set_name(world);
  EXPECT_LT(Must(server.worlds(), &v1::WorldService::Stub::DeleteWorld, request).stamp().step(), kMany);

  ExpectRefusal(driver.NextRefusal(), Reason::kWorldNotFound, "world");
  ExpectRefusal(driver.NextRefusal(), Reason::kWorldNotFound, "world");
  driver.CloseInput();
  EXPECT_FALSE(driver.Read());
  EXPECT_TRUE(driver.Finish().ok());
}

TEST(Drive, StopsAtAStepBoundaryWhenItsCallerIsGone) {
  constexpr uint32_t kMany = 100000;
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  for (int i = 0; i < 10; ++i) server.AddBall(world, 1 + i);
  v1::GetWorldRequest get;
  get.set_name(world);
  {
    Driver driver(server);
    driver.Send(StepOf(world, kMany));
    driver.Send(StepOf(world, kMany));
    while (Must(server.worlds(), &v1::WorldService::Stub::GetWorld, get).stamp().step() == 0) {
    }
    driver.Cancel();
    EXPECT_FALSE(driver.Read());
    EXPECT_EQ(driver.Finish().code(), absl::StatusCode::kCancelled);
  }

  const uint64_t step = StepAtRest(server, world);
  EXPECT_LT(step, kMany);
  EXPECT_EQ(StepAtRest(server, world), step);
}

TEST(Drive, EndsWithTheServer) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  Driver driver(server);
  driver.Send(StepOf(world));
  driver.Next();

  const auto begin = std::chrono::steady_clock::now();
  server.Stop(kPatience);

  EXPECT_LT(std::chrono::steady_clock::now() - begin, kPatience) << "an idle drive held the server up";
  EXPECT_FALSE(driver.Read());
  ExpectRefusal(driver.Finish(), Reason::kDraining, "");
}

TEST(Drive, DoesNoMoreForAClientThatDoesNotReadThanItCanKeep) {
  // Replies of a megabyte each: gRPC takes a few on its own, the drive its bound, and then the world stands still.
  constexpr int kEntities = 15000;
  constexpr uint64_t kTakenByTransport = 64;
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(0);
  for (int i = 0; i < kEntities; ++i) request.add_commands()->mutable_create_entity()->mutable_entity();
  Must(server.simulation(), &Simulation::Step, request);
  Driver driver(server);
  std::atomic<uint64_t> written = 0;
  std::thread flood([&] {
    while (driver.Send(StepOf(world))) ++written;
  });
  // It stands still once it has not moved for a while.
  v1::GetWorldRequest get;
  get.set_name(world);
  uint64_t step = 0;
  for (int still = 0; still < 20;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const uint64_t now = Must(server.worlds(), &v1::WorldService::Stub::GetWorld, get).stamp().step();
    still = now == step && now > 0 ? still + 1 : 0;
    step = now;
  }

  EXPECT_LE(step, genphys::Drive::kInFlightMax + kTakenByTransport);
  // Nothing is lost, and it goes on when the client reads.
  for (uint64_t i = 1; i <= step + 10; ++i) EXPECT_EQ(driver.Next().response().stamp().step(), i);
  driver.Cancel();
  flood.join();
  EXPECT_GT(written, step);
}

}  // namespace
}  // namespace genphys::testing

// A request with an id is done once, however often it arrives.
#include <gtest/gtest.h>

#include <future>
#include <vector>

#include "support/test_server.h"

namespace genphys::testing {
namespace {

using Simulation = v1::SimulationService::Stub;

TEST(RepeatedRequest, ToAWorldGetsTheSameBytesAndIsNotDoneAgain) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::StepRequest request;
  request.set_world(world);
  request.set_request_id("one");
  request.add_commands()->mutable_create_entity()->mutable_entity()->set_display_name("only one");
  request.mutable_frame()->set_poses(true);
  const std::string bytes = request.SerializeAsString();
  std::string first, second;
  ASSERT_TRUE(CallRaw(server.channel(), "/genphys.v1.SimulationService/Step", bytes, &first).ok());
  server.Step(world, 5);

  ASSERT_TRUE(CallRaw(server.channel(), "/genphys.v1.SimulationService/Step", bytes, &second).ok());

  EXPECT_FALSE(first.empty());
  EXPECT_EQ(first, second);
  EXPECT_EQ(server.Step(world).stamp().step(), 7u);
}

TEST(RepeatedRequest, WithoutAnIdIsDoneAgain) {
  TestServer server;
  v1::StepRequest request;
  request.set_world(server.CreateWorld().world().name());

  EXPECT_EQ(Must(server.simulation(), &Simulation::Step, request).stamp().step(), 1u);
  EXPECT_EQ(Must(server.simulation(), &Simulation::Step, request).stamp().step(), 2u);
}

TEST(RepeatedRequest, ThatAsksForSomethingElseIsRefused) {
  TestServer server;
  v1::StepRequest request;
  request.set_world(server.CreateWorld().world().name());
  request.set_request_id("one");
  Must(server.simulation(), &Simulation::Step, request);
  request.set_steps(2);

  ExpectRefusal(MustNot(server.simulation(), &Simulation::Step, request), Reason::kInvalidValue, "request_id");
}

TEST(RepeatedRequest, ThatWasRefusedIsTriedAgain) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::StepRequest request;
  request.set_world(world);
  request.set_request_id("one");
  request.set_expected_step(1);
  ExpectRefusal(MustNot(server.simulation(), &Simulation::Step, request), Reason::kStepMismatch, "expected_step");
  server.Step(world);

  EXPECT_EQ(Must(server.simulation(), &Simulation::Step, request).stamp().step(), 2u);
}

TEST(RepeatedRequest, ForAWorldMakesOneEvenWhenBothAreUnderWay) {
  constexpr int kCallers = 8;
  TestServer server;
  v1::CreateWorldRequest request;
  request.set_request_id("one");
  const std::string bytes = request.SerializeAsString();
  std::vector<std::future<std::string>> replies;

  for (int i = 0; i < kCallers; ++i) {
    replies.push_back(std::async(std::launch::async, [&] {
      std::string reply;
      const grpc::Status status = CallRaw(server.channel(), "/genphys.v1.WorldService/CreateWorld", bytes, &reply);
      EXPECT_TRUE(status.ok()) << status.error_message();
      return reply;
    }));
  }

  const std::string first = replies.front().get();
  for (size_t i = 1; i < replies.size(); ++i) EXPECT_EQ(replies[i].get(), first);
  const auto worlds = Must(server.worlds(), &v1::WorldService::Stub::ListWorlds, v1::ListWorldsRequest());
  EXPECT_EQ(worlds.worlds_size(), 1);
}

}  // namespace
}  // namespace genphys::testing

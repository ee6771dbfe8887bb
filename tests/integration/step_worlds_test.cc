// StepWorlds: many worlds in one call, each as if it were alone.
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "conformance/engine_test.h"
#include "genphys/wire/early_end.h"
#include "genphys/wire/error.h"
#include "support/sweep.h"
#include "support/test_server.h"

namespace genphys::testing {
namespace {

using Simulation = v1::SimulationService::Stub;
using google::protobuf::util::MessageDifferencer;

struct Outcome {
  std::map<uint32_t, v1::StepWorldsResult> results;
  int messages = 0;
  Status end;
};

Outcome CallStepWorlds(TestServer& server, const v1::StepWorldsRequest& request,
                       std::chrono::milliseconds time = kPatience) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + time);
  const auto reader = server.simulation().StepWorlds(&context, request);
  Outcome outcome;
  for (v1::StepWorldsResponse message; reader->Read(&message); ++outcome.messages) {
    for (const v1::StepWorldsResult& result : message.results()) {
      EXPECT_TRUE(outcome.results.emplace(result.index(), result).second)
          << "index " << result.index() << " came twice";
    }
  }
  outcome.end = Received(reader->Finish());
  return outcome;
}

void AddBox(v1::StepRequest& request, double x, double z) {
  v1::Entity& box = *request.add_commands()->mutable_create_entity()->mutable_entity();
  v1::Vector3& half =
      *box.mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_box()->mutable_half_extents();
  half.set_x(0.5), half.set_y(0.5), half.set_z(0.5);
  box.mutable_pose()->mutable_position()->set_x(x);
  box.mutable_pose()->mutable_position()->set_z(z);
}

// A heap of boxes that still falls, another one for each seed.
std::string MakeHeap(TestServer& server, const std::string& engine, int seed) {
  constexpr int kBoxes = 12;
  v1::World world;
  world.set_engine("engines/" + engine);
  world.set_record_state_hash(true);
  v1::StepRequest request;
  request.set_world(server.CreateWorld(world).world().name());
  request.set_steps(0);
  for (int i = 0; i < kBoxes; ++i) AddBox(request, 0.3 * (i % 3) + 0.01 * seed, 0.6 + 1.1 * i);
  Must(server.simulation(), &Simulation::Step, request);
  return request.world();
}

v1::StepRequest Watched(const std::string& world, uint32_t steps) {
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(steps);
  request.mutable_frame()->set_poses(true);
  request.mutable_frame()->set_velocities(true);
  request.mutable_events();
  return request;
}

class StepWorlds : public EngineTest {};

INSTANTIATE_TEST_SUITE_P(Engines, StepWorlds, ::testing::ValuesIn(EnginesWithContacts()), EngineName);

TEST_P(StepWorlds, AnswersEachWorldWhatStepWouldHave) {
  constexpr int kWorlds = 100;  // more than are under way at once
  constexpr uint32_t kSteps = kSweepStride == 1 ? 40 : 12;
  TestServer server;
  v1::StepWorldsRequest request;
  std::vector<std::string> twins;
  for (int i = 0; i < kWorlds; ++i) {
    *request.add_requests() = Watched(MakeHeap(server, GetParam(), i), kSteps);
    twins.push_back(MakeHeap(server, GetParam(), i));
  }

  const Outcome outcome = CallStepWorlds(server, request);

  EXPECT_TRUE(outcome.end.ok()) << outcome.end;
  ASSERT_EQ(outcome.results.size(), size_t{kWorlds});
  for (int i = 0; i < kWorlds; ++i) {
    v1::StepResponse together = outcome.results.at(static_cast<uint32_t>(i)).response();
    v1::StepResponse alone =
        Must(server.simulation(), &Simulation::Step, Watched(twins[static_cast<size_t>(i)], kSteps));
    EXPECT_GT(alone.events().events_size(), 0);
    EXPECT_TRUE(together.stamp().has_state_hash());
    // Only the epochs of two worlds differ.
    for (v1::StepResponse* each : {&together, &alone}) {
      each->mutable_stamp()->clear_epoch();
      each->mutable_frame()->mutable_stamp()->clear_epoch();
    }
    EXPECT_TRUE(MessageDifferencer::Equals(together, alone)) << "world " << i;
  }
}

TEST(StepWorldsCall, TellsWhatOneWorldRefusesAndStepsTheOthers) {
  TestServer server;
  const std::string good = server.CreateWorld().world().name(), other = server.CreateWorld().world().name();
  v1::StepWorldsRequest request;
  request.add_requests()->set_world(good);
  request.add_requests()->set_world("worlds/nobody");
  v1::StepRequest& wrong = *request.add_requests();
  wrong.set_world(good);
  wrong.add_commands()->mutable_delete_entity()->set_entity_id(12345);
  v1::StepRequest& late = *request.add_requests();
  late.set_world(other);
  late.set_expected_step(7);
  request.add_requests()->set_world(other);

  const Outcome outcome = CallStepWorlds(server, request);

  EXPECT_TRUE(outcome.end.ok()) << outcome.end;
  ASSERT_EQ(outcome.results.size(), 5u);
  EXPECT_EQ(outcome.results.at(0).response().stamp().step(), 1u);
  const auto refusal = [&](uint32_t index) { return DecodeRefusal(outcome.results.at(index).refusal()); };
  ExpectRefusal(refusal(1), Reason::kWorldNotFound, "world");
  ExpectRefusal(refusal(2), Reason::kEntityNotFound, "commands[0].delete_entity.entity_id");
  ExpectRefusal(refusal(3), Reason::kStepMismatch, "expected_step");
  EXPECT_EQ(outcome.results.at(1).refusal().code(), static_cast<int>(grpc::StatusCode::NOT_FOUND));
  EXPECT_EQ(outcome.results.at(4).response().stamp().step(), 1u);
}

TEST(StepWorldsCall, TakesAWorldThatIsNamedTwiceInOrder) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::StepWorldsRequest request;
  for (uint64_t i = 0; i < 200; ++i) {
    request.add_requests()->set_world(world);
    request.mutable_requests()->rbegin()->set_expected_step(i);
  }

  const Outcome outcome = CallStepWorlds(server, request);

  ASSERT_EQ(outcome.results.size(), 200u);
  for (uint32_t i = 0; i < 200; ++i) EXPECT_EQ(outcome.results.at(i).response().stamp().step(), i + 1);
  EXPECT_LE(outcome.messages, 200);
}

TEST(StepWorldsCall, RefusesARequestThatIsWrongAsAWhole) {
  constexpr int kRequestsMax = 4096;
  TestServer server;
  v1::StepWorldsRequest request;
  ExpectRefusal(CallStepWorlds(server, request).end, Reason::kMissingField, "requests");

  for (int i = 0; i < kRequestsMax; ++i) request.add_requests()->set_world("worlds/nobody");
  const Outcome most = CallStepWorlds(server, request);
  EXPECT_TRUE(most.end.ok()) << most.end;
  EXPECT_EQ(most.results.size(), size_t{kRequestsMax});

  request.add_requests()->set_world("worlds/nobody");
  ExpectRefusal(CallStepWorlds(server, request).end, Reason::kOutOfRange, "requests");
}

// Each of them has its turn, and none is still at it when nobody waits any more. How long until a machine, however
// busy, has made a step of each and told of it is found by trying.
TEST(StepWorldsCall, TellsHowFarEachOfManySlowWorldsCameBeforeTheDeadline) {
  constexpr uint32_t kMany = 100000, kWorlds = 20;
  TestServer server;
  v1::StepWorldsRequest request;
  std::vector<uint64_t> steps;
  for (uint32_t i = 0; i < kWorlds; ++i) {
    v1::StepRequest& each = *request.add_requests();
    each.set_world(MakeHeap(server, EnginesWithContacts().front(), static_cast<int>(i)));
    each.set_steps(kMany);
    steps.push_back(0);
  }
  request.add_requests()->set_world(server.CreateWorld().world().name());
  for (std::chrono::milliseconds time(500); time < kPatience; time *= 2) {
    const Outcome outcome = CallStepWorlds(server, request, time);
    size_t told = 0;
    for (uint32_t i = 0; i < kWorlds; ++i) {
      const uint64_t before =
          std::exchange(steps[i], server.Step(request.requests(static_cast<int>(i)).world(), 0).stamp().step());
      if (!outcome.results.contains(i)) continue;
      const Status refusal = DecodeRefusal(outcome.results.at(i).refusal());
      EXPECT_EQ(refusal.code(), absl::StatusCode::kDeadlineExceeded);
      const std::optional<EarlyEnd> end = EarlyEndOf(refusal);
      if (!end) continue;
      EXPECT_EQ(end->step, steps[i]);
      EXPECT_EQ(end->steps_done, steps[i] - before);
      if (end->steps_done > 0) ++told;
    }
    if (!outcome.end.ok() || told < kWorlds || !outcome.results.contains(kWorlds)) continue;
    EXPECT_TRUE(outcome.results.at(kWorlds).has_response()) << "it is light";
    return;
  }
  FAIL() << "not all were told before the deadline";
}

TEST(StepWorldsCall, StopsItsWorldsWhenTheCallerIsGone) {
  constexpr uint32_t kMany = 100000;
  TestServer server;
  const std::string engine = EnginesWithContacts().front();
  v1::StepWorldsRequest request;
  for (int i = 0; i < 3; ++i) {
    *request.add_requests() = Watched(MakeHeap(server, engine, i), kMany);
    request.mutable_requests(i)->mutable_commands()->Clear();
  }
  grpc::ClientContext context;
  const auto reader = server.simulation().StepWorlds(&context, request);
  v1::GetWorldRequest get;
  get.set_name(request.requests(0).world());
  while (Must(server.worlds(), &v1::WorldService::Stub::GetWorld, get).stamp().step() == 0) {
  }

  context.TryCancel();

  v1::StepWorldsResponse message;
  EXPECT_FALSE(reader->Read(&message));
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
  for (const v1::StepRequest& each : request.requests()) EXPECT_LT(server.Step(each.world()).stamp().step(), kMany);
}

}  // namespace
}  // namespace genphys::testing

// Streams of events as a subscriber sees them.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "support/test_server.h"

namespace genphys::testing {
namespace {

using Simulation = v1::SimulationService::Stub;
using Response = v1::WatchEventsResponse;

// One stream and what was read from it.
class Watch {
 public:
  Watch(TestServer& server, v1::WatchEventsRequest request) {
    context_.set_deadline(std::chrono::system_clock::now() + kPatience);
    reader_ = server.simulation().WatchEvents(&context_, request);
  }
  Watch(TestServer& server, const std::string& world) : Watch(server, RequestFor(world)) {}
  ~Watch() {
    context_.TryCancel();
    if (!ended_) reader_->Finish();
  }

  static v1::WatchEventsRequest RequestFor(const std::string& world) {
    v1::WatchEventsRequest request;
    request.set_world(world);
    return request;
  }

  // The next message; nothing once the stream has ended.
  std::optional<Response> Read() {
    Response response;
    if (!reader_->Read(&response)) return std::nullopt;
    return response;
  }
  // The next message, which is there.
  Response Next() {
    std::optional<Response> response = Read();
    EXPECT_TRUE(response) << "the stream has ended";
    return response.value_or(Response());
  }
  // Reads on until the batch that was looked at up to `sequence`; all events on the way.
  std::vector<v1::Event> ReadUpTo(uint64_t sequence) {
    std::vector<v1::Event> events;
    for (uint64_t reached = 0; reached < sequence;) {
      const std::optional<Response> response = Read();
      if (!response) {
        ADD_FAILURE() << "the stream ended after event " << reached;
        break;
      }
      for (const v1::Event& event : response->batch().events()) events.push_back(event);
      reached = response->batch().last_sequence();
    }
    return events;
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

void CreatePlaces(TestServer& server, const std::string& world, int count) {
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(0);
  for (int i = 0; i < count; ++i) request.add_commands()->mutable_create_entity()->mutable_entity();
  Must(server.simulation(), &Simulation::Step, request);
}

TEST(WatchEvents, SaysAtOnceWhereItStands) {
  TestServer server;
  const auto created = server.CreateWorld();
  server.AddBall(created.world().name(), 3);

  const Response first = Watch(server, created.world().name()).Next();

  EXPECT_EQ(first.stamp().epoch(), created.stamp().epoch());
  EXPECT_EQ(first.batch().events_size(), 0);
  EXPECT_EQ(first.batch().first_sequence(), 3u);  // the floor and the ball came before
  EXPECT_EQ(first.batch().last_sequence(), 2u);
}

TEST(WatchEvents, TellsOfABallThatFallsRestsAndSleepsInOrder) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  Watch watch(server, world);
  watch.Next();

  const uint64_t ball = server.AddBall(world, 1.5);
  server.Step(world, 300);
  const auto listed = [&] {
    v1::ListEntitiesRequest request;
    request.set_world(world);
    return Must(server.simulation(), &Simulation::ListEntities, request);
  }();
  const std::vector<v1::Event> events = watch.ReadUpTo(listed.last_sequence());

  ASSERT_GE(events.size(), 3u);
  for (size_t i = 0; i < events.size(); ++i) EXPECT_EQ(events[i].sequence(), i + 2);
  EXPECT_EQ(events[0].entity_created().entity().id(), ball);
  EXPECT_TRUE(events[1].has_contact_began());
  EXPECT_GT(events[1].contact_began().points_size(), 0);
  EXPECT_EQ(events.back().entity_slept().entity_id(), ball);
}

TEST(WatchEvents, GoesOnAfterTheLastNumberReceived) {
  TestServer server;
  const auto created = server.CreateWorld();
  const std::string world = created.world().name();
  CreatePlaces(server, world, 9);
  v1::WatchEventsRequest request = Watch::RequestFor(world);
  request.set_epoch(created.stamp().epoch());
  request.set_after_sequence(4);

  const Response first = Watch(server, request).Next();

  EXPECT_EQ(first.batch().first_sequence(), 5u);
  EXPECT_EQ(first.batch().last_sequence(), 10u);
  EXPECT_EQ(first.batch().events_size(), 6);
  EXPECT_EQ(first.batch().events(0).sequence(), 5u);
}

TEST(WatchEvents, RefusesANumberThatWasNeverGiven) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::WatchEventsRequest request = Watch::RequestFor(world);

  request.set_after_sequence(2);
  Watch beyond(server, request);
  EXPECT_FALSE(beyond.Read());
  ExpectRefusal(beyond.Finish(), Reason::kOutOfRange, "after_sequence");

  request.set_after_sequence(1);
  EXPECT_EQ(Watch(server, request).Next().batch().last_sequence(), 1u);
}

TEST(WatchEvents, RefusesWorldsThatAreNotThereAndBadFilters) {
  TestServer server;
  Watch unknown(server, "worlds/none");
  EXPECT_FALSE(unknown.Read());
  ExpectRefusal(unknown.Finish(), Reason::kWorldNotFound, "world");
  Watch unnamed(server, "");
  EXPECT_FALSE(unnamed.Read());
  ExpectRefusal(unnamed.Finish(), Reason::kMissingField, "world");
}

TEST(WatchEvents, LeavesOutWhatTheFilterDoesNotNameAndCountsItAsSeen) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::WatchEventsRequest request = Watch::RequestFor(world);
  request.mutable_filter()->mutable_kinds()->set_contacts(true);
  Watch watch(server, request);
  watch.Next();

  server.AddBall(world, 0.6);
  server.Step(world, 30);

  // A bookmark may come first.
  Response response = watch.Next();
  while (response.batch().events_size() == 0) response = watch.Next();
  ASSERT_EQ(response.batch().events_size(), 1);
  EXPECT_EQ(response.batch().events(0).sequence(), 3u);
  EXPECT_TRUE(response.batch().events(0).has_contact_began());
  EXPECT_EQ(response.batch().events(0).contact_began().points_size(), 0);  // not asked for
}

TEST(WatchEvents, SendsABookmarkWhenTheFilterLetNothingThrough) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::WatchEventsRequest request = Watch::RequestFor(world);
  request.mutable_filter()->mutable_kinds()->set_contacts(true);
  Watch watch(server, request);
  watch.Next();

  CreatePlaces(server, world, 20);

  const Response bookmark = watch.Next();
  EXPECT_EQ(bookmark.batch().events_size(), 0);
  EXPECT_EQ(bookmark.batch().last_sequence(), 21u);
}

TEST(WatchEvents, TellsTheExactRangeThatIsGoneAndGoesOn) {
  constexpr int kForgotten = 65536;  // a chunk that is as large as the log
  TestServer server;
  const auto created = server.CreateWorld();
  const std::string world = created.world().name();
  CreatePlaces(server, world, kForgotten);
  CreatePlaces(server, world, 2);
  v1::WatchEventsRequest request = Watch::RequestFor(world);
  request.set_after_sequence(7);
  Watch watch(server, request);

  const Response gap = watch.Next();
  const Response touching = watch.Next();
  const Response rest = watch.Next();

  EXPECT_EQ(gap.gap().first_sequence(), 8u);
  EXPECT_EQ(gap.gap().last_sequence(), uint64_t{kForgotten} + 1);
  EXPECT_EQ(gap.stamp().epoch(), created.stamp().epoch());
  EXPECT_TRUE(touching.has_batch());
  EXPECT_EQ(touching.batch().events_size(), 0);
  EXPECT_EQ(rest.batch().first_sequence(), uint64_t{kForgotten} + 2);
  EXPECT_EQ(rest.batch().events_size(), 2);
}

TEST(WatchEvents, BeginsAnewWithTheEpochOfAReset) {
  TestServer server;
  const auto created = server.CreateWorld();
  const std::string world = created.world().name();
  const uint64_t ball = server.AddBall(world, 3);
  Watch watch(server, world);
  watch.Next();
  server.Step(world, 60);
  v1::ResetWorldRequest reset;
  reset.set_name(world);
  const auto after = Must(server.worlds(), &v1::WorldService::Stub::ResetWorld, reset);

  Response response = watch.Next();
  while (response.stamp().epoch() == created.stamp().epoch()) response = watch.Next();

  EXPECT_EQ(response.stamp().epoch(), after.stamp().epoch());
  // What was there before the first step appears again: the floor and the ball.
  ASSERT_EQ(response.batch().events_size(), 2);
  EXPECT_EQ(response.batch().first_sequence(), 1u);
  EXPECT_EQ(response.batch().events(1).entity_created().entity().id(), ball);
  server.Step(world, 60);
  EXPECT_EQ(watch.Next().batch().first_sequence(), 3u);
}

TEST(WatchEvents, EndsWellWithItsWorld) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  Watch watch(server, world);
  watch.Next();
  v1::DeleteWorldRequest request;
  request.set_name(world);
  Must(server.worlds(), &v1::WorldService::Stub::DeleteWorld, request);

  EXPECT_FALSE(watch.Read());
  EXPECT_TRUE(watch.Finish().ok());
}

TEST(WatchEvents, ThatNobodyReadsHoldsUpNothing) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  Watch slow(server, world);
  // More than gRPC's windows take, so that the server's writes wait.
  for (int i = 0; i < 40; ++i) CreatePlaces(server, world, 5000);

  Watch quick(server, world);
  EXPECT_EQ(quick.Next().batch().last_sequence(), 200001u);
  // The one that slept gets every number, or is told which it does not.
  uint64_t next = 0;
  bool has_gap = false;
  while (next <= 200001) {
    const Response response = slow.Next();
    if (response.has_gap()) {
      has_gap = true;
      EXPECT_EQ(response.gap().first_sequence(), next);
      next = response.gap().last_sequence() + 1;
    } else {
      if (next != 0) {
        EXPECT_EQ(response.batch().first_sequence(), next);
      }
      next = response.batch().last_sequence() + 1;
    }
    if (HasFailure()) break;
  }
  EXPECT_TRUE(has_gap);
}

}  // namespace
}  // namespace genphys::testing

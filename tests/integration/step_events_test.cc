// The events in the reply to a Step, of which there may be more than it has room for.
#include <gtest/gtest.h>

#include <string>

#include "genphys/client/client.h"
#include "support/test_server.h"

namespace genphys::testing {
namespace {

using Simulation = v1::SimulationService::Stub;

constexpr size_t kVisualBytes = 1 << 20;
constexpr int kRoom = 16;  // so many of these visuals
constexpr int kFirst = 2;  // number of the first event after that of the floor

void AddLargeVisual(v1::StepRequest& request) {
  request.add_commands()->mutable_create_entity()->mutable_entity()->mutable_visual()->mutable_data()->assign(
      kVisualBytes, 'x');
}

v1::StepRequest LargeVisuals(const std::string& world, int count) {
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(0);
  request.mutable_events();
  for (int i = 0; i < count; ++i) AddLargeVisual(request);
  return request;
}

TEST(StepEvents, AreAllThereUpToTheBound) {
  TestServer server;

  const auto stepped =
      Must(server.simulation(), &Simulation::Step, LargeVisuals(server.CreateWorld().world().name(), kRoom));

  EXPECT_EQ(stepped.events().events_size(), kRoom);
  EXPECT_EQ(stepped.events().last_sequence(), uint64_t{kRoom} + 1);
  EXPECT_FALSE(stepped.has_events_left_out());
}

TEST(StepEvents, SayWhichHadNoRoom) {
  TestServer server;
  constexpr int kMore = 3;

  const auto stepped =
      Must(server.simulation(), &Simulation::Step, LargeVisuals(server.CreateWorld().world().name(), kRoom + kMore));

  EXPECT_EQ(stepped.events().events_size(), kRoom);
  EXPECT_EQ(stepped.events().last_sequence(), uint64_t{kRoom} + 1);
  ASSERT_TRUE(stepped.has_events_left_out());
  EXPECT_EQ(stepped.events_left_out().first_sequence(), uint64_t{kRoom} + kFirst);
  EXPECT_EQ(stepped.events_left_out().last_sequence(), uint64_t{kRoom} + kMore + 1);
}

// What nobody asked for takes no room: the ball lands long after more was told than a reply holds.
TEST(StepEvents, LoseNothingToEventsThatTheFilterDrops) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  const uint64_t ball = server.AddBall(world, 1);
  v1::StepRequest request = LargeVisuals(world, kRoom + 3);
  request.mutable_events()->mutable_kinds()->set_contacts(true);
  request.mutable_events()->add_entity_ids(ball);
  request.set_steps(60);

  const auto stepped = Must(server.simulation(), &Simulation::Step, request);

  ASSERT_EQ(stepped.events().events_size(), 1);
  EXPECT_EQ(stepped.events().events(0).contact_began().entity_b(), ball);
  EXPECT_GE(stepped.events().last_sequence(), stepped.events().events(0).sequence());
  EXPECT_FALSE(stepped.has_events_left_out());
}

TEST(StepEvents, ThatHadNoRoomAreToldToWhoWatchesAfterTheLast) {
  TestServer server;
  client::World world = *client::Connect(server.address())->CreateWorld();
  client::StepOptions options;
  for (int i = 0; i < kRoom + 1; ++i) {
    EntityDesc entity;
    entity.visual = Visual{"", "", std::string(kVisualBytes, 'x')};
    options.commands.push_back(CreateEntity{entity});
  }

  const Result<client::StepResult> stepped = world.Step(0, options);

  ASSERT_TRUE(stepped.ok()) << stepped.status();
  ASSERT_TRUE(stepped->events_left_out);
  EXPECT_EQ(stepped->events_left_out->first_sequence, stepped->last_sequence + 1);
  EXPECT_EQ(stepped->events_left_out->last_sequence, stepped->last_sequence + 1);
  auto stream = world.WatchEvents({.after = client::StreamPosition{stepped->stamp.epoch, stepped->last_sequence}});
  ASSERT_TRUE(stream.ok()) << stream.status();
  const auto rest = stream->Next(kPatience);
  ASSERT_TRUE(rest.ok() && *rest) << rest.status();
  ASSERT_EQ((*rest)->events.size(), 1u);
  EXPECT_EQ(std::get<EntityCreated>((*rest)->events[0].kind).id.packed(), stepped->created.back().packed());
}

}  // namespace
}  // namespace genphys::testing

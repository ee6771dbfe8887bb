// What a world tells has the same bytes whatever the number of threads, and whatever else they do.
#include <gtest/gtest.h>

#include <thread>

#include "support/scenes.h"
#include "support/test_server.h"

namespace genphys::testing {
namespace {

// Balls that fall from one height after the other on the floor and on each other, and what is told of them.
std::string BytesOfEvents(TestServer& server, const std::string& engine, const std::string& name) {
  v1::World world;
  world.set_name("worlds/" + name);
  world.set_engine("engines/" + engine);
  server.CreateWorld(world);
  v1::StepRequest request;
  request.set_world(world.name());
  for (int i = 0; i < 30; ++i) {
    v1::Entity& entity = *request.add_commands()->mutable_create_entity()->mutable_entity();
    v1::Vector3& position = *entity.mutable_pose()->mutable_position();
    position.set_x(0.7 * (i % 3));
    position.set_y(0.8 * (i / 3 % 3));
    position.set_z(1 + 1.1 * i);
    entity.mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_sphere();
  }
  request.set_steps(300);
  request.mutable_events();
  const v1::StepResponse response = Must(server.simulation(), &v1::SimulationService::Stub::Step, request);
  EXPECT_GT(response.events().events_size(), 100);
  std::string bytes;
  for (const v1::Event& event : response.events().events()) event.AppendToString(&bytes);
  return bytes;
}

class EventBytes : public ::testing::TestWithParam<std::string> {};

TEST_P(EventBytes, AreTheSameOverOneAndTwoThreadsAndOnceMore) {
  std::string expected;
  for (const unsigned workers : {1u, 2u, 2u}) {
    TestServer server(ServerOptions{.workers = workers});
    std::string here, there;
    std::thread beside([&] { there = BytesOfEvents(server, GetParam(), "b"); });
    here = BytesOfEvents(server, GetParam(), "a");
    beside.join();
    if (expected.empty()) expected = here;
    EXPECT_EQ(here, expected) << workers << " threads";
    EXPECT_EQ(there, expected) << workers << " threads";
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, EventBytes, ::testing::ValuesIn(EnginesWithContacts()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace genphys::testing

// Worlds of one server cannot disturb each other: not by a bit.
#include <cmath>
#include <random>
#include <thread>

#include "conformance/engine_test.h"
#include "integration/live_server.h"

namespace genphys::testing {
namespace {

constexpr int kSteps = 1000;
constexpr uint32_t kContactsMin = 20;

// What a client saw of its world.
struct Course {
  std::vector<uint64_t> hashes;  // after every step
  size_t contacts_begun = 0;
  uint32_t contacts_at_end = 0;
};

client::World MakePile(const client::Server& server, const std::string& engine) {
  client::WorldOptions options = WorldOn(engine);
  // A pile that sleeps would have nothing to be disturbed.
  options.world.default_auto_disable.enabled = false;
  client::World world = Value(server.CreateWorld(options));
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> jitter(-0.1, 0.1);
  const Shape shapes[] = {Box{{0.4, 0.3, 0.35}}, Sphere{0.4}, Capsule{0.25, 0.25}, Cylinder{0.3, 0.3}};
  for (int i = 0; i < 24; ++i) {
    const Vector3 place(1.1 * (i % 3) + jitter(random), 1.1 * (i / 3 % 3) + jitter(random), 0.8 + 1.2 * (i / 9));
    Value(world.Add(shapes[i % 4], {.position = place, .mass = 1}));
  }
  return world;
}

Course Follow(const std::string& address, const std::string& engine) {
  Course course;
  client::World world = MakePile(Value(client::Connect(address)), engine);
  for (int i = 0; i < kSteps; ++i) {
    const client::StepResult result = Value(world.Step(1, {.stats = true}));
    course.hashes.push_back(result.stamp.state_hash.value());
    course.contacts_begun += Of<ContactBegan>(result.events).size();
    course.contacts_at_end = result.stats->contacts;
  }
  return course;
}

TEST(WorldsOfOneServer, OnDifferentEnginesSteppedAtOnceHaveTheHashesThatTheyHaveAlone) {
  const std::vector<std::string> engines = EnginesWithContacts();
  ASSERT_GE(engines.size(), 2u);
  std::vector<Course> alone;
  for (const std::string& engine : engines) {
    const LiveServer server;
    alone.push_back(Follow(server.address(), engine));
    EXPECT_GT(alone.back().contacts_begun, kContactsMin) << engine;
    EXPECT_GT(alone.back().contacts_at_end, kContactsMin) << engine;
  }

  const LiveServer server;
  std::vector<Course> together(engines.size());
  std::vector<std::thread> clients;
  for (size_t i = 0; i < engines.size(); ++i) {
    clients.emplace_back([&, i] { EXPECT_NO_THROW(together[i] = Follow(server.address(), engines[i])); });
  }
  for (std::thread& client : clients) client.join();

  for (size_t i = 0; i < engines.size(); ++i) EXPECT_EQ(together[i].hashes, alone[i].hashes) << engines[i];
}

class LiveStateHash : public EngineTest {
 protected:
  // The hash of a world in which a ball was put at `x`.
  uint64_t HashWithBallAt(double x) {
    client::World world = Value(connection_.CreateWorld(WorldOn(GetParam())));
    const EntityId ball = Value(world.Add(Sphere{0.5}, {.position = {0, 0, 3}}));
    Value(world.Step(10));
    MustBeOk(world.SetPose({.id = ball, .position = Vector3(x, 0, 3)}));
    return Value(world.Info()).stamp.state_hash.value();
  }

  LiveServer server_;
  client::Server connection_ = server_.Connect();
};

INSTANTIATE_TEST_SUITE_P(Engines, LiveStateHash, ::testing::ValuesIn(EnginesWithContacts()), EngineName);

TEST_P(LiveStateHash, KnowsOneBitOfOneColumn) {
  const uint64_t hash = HashWithBallAt(1.25);

  EXPECT_NE(HashWithBallAt(std::nextafter(1.25, 2)), hash);
  EXPECT_EQ(HashWithBallAt(1.25), hash);
}

}  // namespace
}  // namespace genphys::testing

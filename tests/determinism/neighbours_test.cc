// A world has the bits that it has alone, whoever else is in the process.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <thread>

#include "support/scenes.h"

namespace genphys::testing {
namespace {

constexpr int kSteps = 300;

std::unique_ptr<World> MakePile(const std::string& engine, unsigned seed) {
  auto world = MakeWorld(engine);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> jitter(-0.1, 0.1);
  for (int i = 0; i < 40; ++i) {
    const Vector3 at(1.1 * (i % 3) + jitter(random), 1.1 * (i / 3 % 3) + jitter(random), 0.8 + 1.2 * (i / 9));
    const Shape shapes[] = {Box{{0.4, 0.3, 0.35}}, Sphere{0.4}, Capsule{0.25, 0.25}, Cylinder{0.3, 0.3}};
    EntityDesc body = Body(shapes[i % 4], at);
    body.pose.orientation = Quaternion(1, 3 * jitter(random), 3 * jitter(random), 3 * jitter(random)).normalized();
    Add(*world, body);
  }
  return world;
}

std::vector<uint64_t> HashesOf(const std::string& engine, unsigned seed) {
  const auto world = MakePile(engine, seed);
  std::vector<uint64_t> hashes;
  size_t most = 0;
  for (int i = 0; i < kSteps; ++i) {
    EXPECT_TRUE(world->Step().ok());
    hashes.push_back(world->StateHash());
    most = std::max(most, world->layer_state().touching.size());
  }
  EXPECT_GT(most, 20u) << "a pile, or it would prove nothing";
  return hashes;
}

class Neighbours : public ::testing::TestWithParam<std::string> {};

TEST_P(Neighbours, OnOtherThreadsChangeNoBit) {
  constexpr unsigned kWorlds = 4;
  std::vector<std::vector<uint64_t>> alone, together(kWorlds);
  for (unsigned i = 0; i < kWorlds; ++i) alone.push_back(HashesOf(GetParam(), i));

  std::vector<std::thread> threads;
  for (unsigned i = 0; i < kWorlds; ++i) {
    threads.emplace_back([&, i] { together[i] = HashesOf(GetParam(), i); });
  }
  for (std::thread& thread : threads) thread.join();

  EXPECT_EQ(alone, together);
}

TEST_P(Neighbours, OnTheSameThreadChangeNoBit) {
  const std::vector<uint64_t> alone = HashesOf(GetParam(), 1);
  const auto world = MakePile(GetParam(), 1), neighbour = MakePile(GetParam(), 2);

  std::vector<uint64_t> beside;
  for (int i = 0; i < kSteps; ++i) {
    EXPECT_TRUE(neighbour->Step().ok());
    EXPECT_TRUE(world->Step().ok());
    beside.push_back(world->StateHash());
  }

  EXPECT_EQ(alone, beside);
}

INSTANTIATE_TEST_SUITE_P(Engines, Neighbours, ::testing::ValuesIn(EnginesWithContacts()));

}  // namespace
}  // namespace genphys::testing

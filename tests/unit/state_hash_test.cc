#include "core/src/model/state_hash.h"

#include <gtest/gtest.h>

#include <cstring>

#include "support/scenes.h"

namespace genphys::testing {
namespace {

uint64_t Hash(const StateArrays& state) {
  std::string bytes;
  Serialize(state, bytes);
  return HashBytes(bytes);
}

TEST(StateHash, ChangesWithAnyOneBitOfAnyColumn) {
  const std::unique_ptr<World> world = MakeWorld("none");
  Add(*world, Ball({1, 2, 3}));
  StateArrays state = world->state();
  const uint64_t before = Hash(state);
  const auto flip_each = [&](void* data, size_t size) {
    auto* bytes = static_cast<unsigned char*>(data);
    for (size_t bit = 0; bit < 8 * size; ++bit) {
      bytes[bit / 8] ^= static_cast<unsigned char>(1u << (bit % 8));
      EXPECT_NE(Hash(state), before) << "bit " << bit;
      bytes[bit / 8] ^= static_cast<unsigned char>(1u << (bit % 8));
    }
  };

  for (StateArrays::Columns3* column :
       {&state.positions, &state.linear_velocities, &state.angular_velocities, &state.net_forces, &state.net_torques}) {
    flip_each(column->data(), sizeof(double) * static_cast<size_t>(column->size()));
  }
  flip_each(state.orientations.data(), sizeof(double) * static_cast<size_t>(state.orientations.size()));
  flip_each(state.ids.data(), sizeof(EntityId) * state.ids.size());
  flip_each(state.asleep.data(), state.asleep.size());

  EXPECT_EQ(Hash(state), before);
}

TEST(StateHash, IsTheSameForTheSameHistory) {
  const std::unique_ptr<World> a = MakeWorld("ode"), b = MakeWorld("ode");
  for (World* world : {a.get(), b.get()}) {
    Add(*world, Crate({0, 0, 2}));
    Steps(*world, 60);
  }
  EXPECT_EQ(a->StateHash(), b->StateHash());
}

TEST(StateHash, KnowsOfAPendingForceThatMovedNothingYet) {
  const std::unique_ptr<World> world = MakeWorld("none");
  const EntityId ball = Add(*world, Ball({0, 0, 2}));
  const uint64_t before = world->StateHash();

  Do(*world, ApplyForce{.id = ball, .force = {1, 0, 0}});

  EXPECT_NE(world->StateHash(), before);
}

}  // namespace
}  // namespace genphys::testing

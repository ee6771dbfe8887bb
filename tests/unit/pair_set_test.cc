#include "genphys/pair_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

namespace genphys {
namespace {

TouchingPair PairOf(EntityId a, EntityId b, bool is_sensor = false) { return {{a, b}, is_sensor, false}; }

std::vector<TouchingPair> PairsOf(const PairSet& set, EntityId id) {
  std::vector<TouchingPair> pairs;
  set.VisitOf(id, [&](const TouchingPair& pair) { pairs.push_back(pair); });
  std::ranges::sort(pairs);
  return pairs;
}

// What an ordered set has of one of the two.
std::vector<TouchingPair> PairsOf(const std::set<TouchingPair>& set, EntityId id) {
  std::vector<TouchingPair> pairs;
  for (const TouchingPair& pair : set) {
    if (pair.pair.a == id || pair.pair.b == id) pairs.push_back(pair);
  }
  return pairs;
}

TEST(PairSet, HasWhatAnOrderedSetHasWhateverComesAndGoes) {
  std::mt19937 dice(7);
  std::vector<EntityId> ids;
  for (uint32_t slot = 0; slot < 12; ++slot) ids.insert(ids.end(), {EntityId(slot, 1), EntityId(slot, 2)});
  PairSet set;
  std::set<TouchingPair> expected;
  for (int i = 0; i < 4000; ++i) {
    // The first one touches most, as the ground does.
    const EntityId a = ids[dice() % 3 == 0 ? dice() % ids.size() : 0];
    const EntityId b = ids[dice() % ids.size()];
    if (a.index() == b.index()) continue;
    const TouchingPair pair = PairOf(a, b, dice() % 8 == 0);
    // For a while more come, then more go.
    if (dice() % 4 < (i / 500 % 2 == 0 ? 3 : 1)) {
      set.Insert(pair);
      expected.insert(pair);
    } else {
      set.Erase(pair);
      expected.erase(pair);
    }

    ASSERT_EQ(set.size(), expected.size());
    if (i % 40 != 0) continue;
    ASSERT_EQ(set.Sorted(), std::vector<TouchingPair>(expected.begin(), expected.end()));
    for (const EntityId id : ids) ASSERT_EQ(PairsOf(set, id), PairsOf(expected, id));
  }
}

TEST(PairSet, TellsGenerationsOfOneSlotApart) {
  PairSet set;
  const TouchingPair old = PairOf(EntityId(1, 1), EntityId(2, 1)), young = PairOf(EntityId(1, 2), EntityId(2, 1));
  set.Insert(old);

  EXPECT_EQ(PairsOf(set, EntityId(1, 2)), std::vector<TouchingPair>());
  set.Erase(young);
  EXPECT_EQ(set.size(), 1u);
  EXPECT_EQ(PairsOf(set, EntityId(1, 1)), std::vector<TouchingPair>{old});
}

TEST(PairSet, KnowsNothingOfWhoNeverCame) {
  PairSet set;
  set.Erase(PairOf(EntityId(1, 1), EntityId(2, 1)));

  EXPECT_EQ(set.size(), 0u);
  EXPECT_EQ(PairsOf(set, EntityId(1000, 1)), std::vector<TouchingPair>());
}

}  // namespace
}  // namespace genphys

#include "genphys/resting_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace genphys {
namespace {

using Pairs = RestingPairs<std::string, int>;

// Of all that is kept, ascending.
std::vector<std::string> All(const Pairs& pairs) {
  std::vector<std::string> all;
  pairs.ForEach([&](const std::string& memory) { all.push_back(memory); });
  std::ranges::sort(all);
  return all;
}

std::vector<std::string> Take(Pairs& pairs, int body) {
  std::vector<std::string> taken;
  pairs.TakeOf(body, taken);
  return taken;
}

Pairs Chain() {
  Pairs pairs;
  pairs.Put("floor and 1", std::vector{1});
  pairs.Put("1 and 2", std::vector{1, 2});
  pairs.Put("2 and 3", std::vector{2, 3});
  return pairs;
}

TEST(RestingPairs, AreTakenByEitherBodyAndOnce) {
  Pairs pairs = Chain();
  EXPECT_EQ(Take(pairs, 2), (std::vector<std::string>{"1 and 2", "2 and 3"}));
  EXPECT_EQ(All(pairs), std::vector<std::string>{"floor and 1"});
  EXPECT_TRUE(Take(pairs, 2).empty());
  EXPECT_TRUE(Take(pairs, 3).empty());
  EXPECT_EQ(Take(pairs, 1), std::vector<std::string>{"floor and 1"});
  EXPECT_TRUE(All(pairs).empty());
}

TEST(RestingPairs, AreKeptAnewWhereOthersWereTaken) {
  Pairs pairs = Chain();
  Take(pairs, 1);
  pairs.Put("3 and 4", std::vector{3, 4});
  EXPECT_EQ(All(pairs), (std::vector<std::string>{"2 and 3", "3 and 4"}));
  EXPECT_EQ(Take(pairs, 4), std::vector<std::string>{"3 and 4"});
  EXPECT_EQ(Take(pairs, 3), std::vector<std::string>{"2 and 3"});
}

TEST(RestingPairs, AreNotKeptOfWhatNobodyCanWake) {
  Pairs pairs;
  pairs.Put("floor and wall", std::vector<int>{});
  EXPECT_EQ(All(pairs), std::vector<std::string>{});
}

}  // namespace
}  // namespace genphys

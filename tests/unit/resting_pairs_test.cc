#include "genphys/resting_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <random>
#include <string>
#include <utility>
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

TEST(RestingPairs, AreThoseThatAListWouldHave) {
  std::mt19937 random(1);
  std::map<std::string, std::pair<int, int>> list;
  Pairs pairs;
  for (int i = 0; i < 2000; ++i) {
    const int a = static_cast<int>(random() % 9), b = static_cast<int>(random() % 9);
    if (random() % 3 != 0) {
      if (a == b) continue;
      pairs.Put(std::to_string(i), std::vector{a, b});
      list[std::to_string(i)] = {a, b};
      continue;
    }
    std::vector<std::string> wanted, taken = Take(pairs, a);
    for (const auto& [name, bodies] : list) {
      if (bodies.first == a || bodies.second == a) wanted.push_back(name);
    }
    for (const std::string& name : wanted) list.erase(name);
    std::ranges::sort(taken);
    ASSERT_EQ(taken, wanted) << i;
  }
}

// One that may be woken, a kinematic one say, is in one pair with each of those on it.
TEST(RestingPairs, OfOneFloorAreTakenInAboutTheTimeThatManyFloorsTake) {
  constexpr int kCount = 40'000;
  const auto time_of = [](bool is_one_floor) {
    RestingPairs<int, int> pairs;
    for (int i = 1; i <= kCount; ++i) pairs.Put(i, std::vector{is_one_floor ? 0 : -i, i});
    std::vector<int> taken;
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 1; i <= kCount; ++i) pairs.TakeOf(i, taken);
    EXPECT_EQ(taken.size(), size_t{kCount});
    return std::chrono::steady_clock::now() - begin;
  };
  const auto usual = time_of(false);
  EXPECT_LT(time_of(true), 8 * usual);
}

TEST(RestingPairs, AreNotKeptOfWhatNobodyCanWake) {
  Pairs pairs;
  pairs.Put("floor and wall", std::vector<int>{});
  EXPECT_EQ(All(pairs), std::vector<std::string>{});
}

}  // namespace
}  // namespace genphys

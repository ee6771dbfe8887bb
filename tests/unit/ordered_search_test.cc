#include "core/src/pairs/ordered_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

namespace genphys {
namespace {

using Item = std::pair<int, int>;

std::vector<Item> Items(size_t count, std::mt19937& dice) {
  std::vector<Item> items;
  for (size_t i = 0; i < count; ++i) items.emplace_back(static_cast<int>(dice() % 50), static_cast<int>(i));
  std::ranges::sort(items);
  return items;
}

TEST(OrderedSearch, FindsWhatABinarySearchFindsInWhateverOrderKeysCome) {
  std::mt19937 dice(11);
  OrderedSearch search;
  for (int list = 0; list < 300; ++list) {
    // One that knows another list's last place.
    const std::vector<Item> items = Items(dice() % 40, dice);
    std::vector<int> keys;
    for (int i = 0; i < 40; ++i) keys.push_back(static_cast<int>(dice() % 54) - 2);
    if (list % 3 == 0) std::ranges::sort(keys);
    if (list % 3 == 1) std::ranges::sort(keys, std::greater<>());
    for (const int key : keys) {
      const auto found = search.LowerBound(items, key, &Item::first);
      const auto expected = std::ranges::lower_bound(items, key, {}, &Item::first);
      ASSERT_EQ(found - items.begin(), expected - items.begin()) << "for " << key << " in list " << list;
    }
  }
}

TEST(OrderedSearch, LooksAtFewOfALongListWhereKeysComeInItsOrder) {
  constexpr int kLong = 100'000;
  std::vector<int> list(kLong);
  for (int i = 0; i < kLong; ++i) list[static_cast<size_t>(i)] = i;
  OrderedSearch search;
  int looks = 0;
  const auto look = [&](int value) {
    ++looks;
    return value;
  };
  for (int key = 0; key < kLong; ++key) search.LowerBound(list, key, look);
  EXPECT_LE(looks, 5 * kLong);
}

}  // namespace
}  // namespace genphys

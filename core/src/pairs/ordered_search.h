#pragma once
#include <algorithm>
#include <cstddef>
#include <functional>
#include <iterator>
#include <ranges>

namespace genphys {

/// Finds places in an ordered list for keys that mostly come in the order of the list: each is looked for from the last
/// place on, in leaps that grow (Bentley and Yao, "An almost optimal algorithm for unbounded searching", Inf. Process.
/// Lett. 5, 1976). The list may be another one each time; where the last place was costs or spares time only.
class OrderedSearch {
 public:
  /// The first of `list` that does not come before `key`, as std::ranges::lower_bound() finds it.
  template <std::ranges::random_access_range List, typename Key, typename Projection = std::identity>
  auto LowerBound(List&& list, const Key& key, Projection projection = {}) {
    const auto begin = std::ranges::begin(list), end = std::ranges::end(list);
    const auto is_before = [&](auto place) { return std::invoke(projection, *place) < key; };
    auto from = begin + std::min(place_, end - begin);
    if (from != begin && !is_before(from - 1)) from = begin;
    auto to = from;
    for (std::ptrdiff_t leap = 1; to != end && is_before(to); leap *= 2) {
      from = to + 1;
      to += std::min(leap, end - to);
    }
    const auto found = std::ranges::lower_bound(from, to, key, std::less<>(), projection);
    place_ = found - begin;
    return found;
  }

 private:
  std::ptrdiff_t place_ = 0;
};

}  // namespace genphys

#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "impacts/impact_solve.h"
#include "impacts/ties.h"
#include "pairs/disjoint_sets.h"

namespace genphys {

/// Sorts blows into groups that have no movable body in common, each in the order in which the blows came.
class BlowGroups {
 public:
  BlowGroups(std::span<const Blow> blows, std::span<const StruckBody> bodies, const Ties& ties) : sets_(bodies.size()) {
    const auto is_movable = [&](uint32_t body) { return bodies[body].inverse_mass > 0; };
    for (uint32_t body = 0; body < bodies.size(); ++body) {
      const std::span<const uint32_t> tied = ties.With(body);
      if (!tied.empty() && tied.front() != body) sets_.Join(tied.front(), body);
    }
    for (const Blow& blow : blows) {
      if (is_movable(blow.body_a) && is_movable(blow.body_b)) sets_.Join(blow.body_a, blow.body_b);
    }
    order_.reserve(blows.size());
    for (uint32_t i = 0; i < blows.size(); ++i) {
      const Blow& blow = blows[i];
      order_.emplace_back(sets_.Find(is_movable(blow.body_a) ? blow.body_a : blow.body_b), i);
    }
    std::sort(order_.begin(), order_.end());
    size_t size = 0;
    Walk([&](uint32_t) { ++size; }, [&] { largest_ = std::max(largest_, std::exchange(size, 0)); });
  }

  /// Blows of the largest one.
  size_t largest() const { return largest_; }

  /// Calls visit(blow) for each blow, and done() after the last one of each group.
  template <typename Visit, typename Done>
  void Walk(Visit&& visit, Done&& done) const {
    for (size_t i = 0; i < order_.size(); ++i) {
      visit(order_[i].second);
      if (i + 1 == order_.size() || order_[i + 1].first != order_[i].first) done();
    }
  }

 private:
  DisjointSets sets_;
  std::vector<std::pair<uint32_t, uint32_t>> order_;  // root and blow
  size_t largest_ = 0;
};

}  // namespace genphys

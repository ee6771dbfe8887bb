#include "joints/row_plan.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

namespace genphys {

bool RowPlan::Make(std::span<const Group> groups) {
  if (std::ranges::equal(groups, groups_)) return is_cheap_;
  groups_.assign(groups.begin(), groups.end());
  is_cheap_ = FindNeighbours() && Eliminate();
  if (!is_cheap_) return false;
  Place();
  FindTargets();
  FindCouplings();
  return true;
}

// False if one body is held by so many that those alone take too long.
bool RowPlan::FindNeighbours() {
  uint32_t body_count = 0;
  for (const Group& group : groups_) {
    for (const uint32_t body : group.bodies) {
      if (body != kStill) body_count = std::max(body_count, body + 1);
    }
  }
  holders_.assign(body_count, {});
  for (uint32_t g = 0; g < groups_.size(); ++g) {
    for (uint8_t side = 0; side < 2; ++side) {
      if (groups_[g].bodies[side] != kStill) holders_[groups_[g].bodies[side]].emplace_back(g, side);
    }
  }
  neighbours_.assign(groups_.size(), {});
  for (const auto& holders : holders_) {
    double rows = 0;
    for (const auto& [group, side] : holders) rows += groups_[group].size;
    if (rows * rows * rows / 6 > kOperationsMax) return false;
    for (const auto& [group, side] : holders) {
      for (const auto& [other, other_side] : holders) {
        if (other != group) neighbours_[group].push_back(other);
      }
    }
  }
  for (std::vector<uint32_t>& list : neighbours_) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return true;
}

// Afterwards the neighbours of a group are those that are eliminated later.
bool RowPlan::Eliminate() {
  const auto rows_around = [&](uint32_t group) {
    uint32_t rows = 0;
    for (const uint32_t other : neighbours_[group]) rows += groups_[other].size;
    return rows;
  };
  std::set<std::pair<uint32_t, uint32_t>> waiting;
  for (uint32_t g = 0; g < groups_.size(); ++g) waiting.emplace(rows_around(g), g);
  order_.clear();
  positions_.assign(groups_.size(), 0);
  double operations = 0;
  while (!waiting.empty()) {
    const auto [around, group] = *waiting.begin();
    waiting.erase(waiting.begin());
    positions_[group] = static_cast<uint32_t>(order_.size());
    order_.push_back(group);
    const double size = groups_[group].size, others = around;
    operations += size * (size * size / 6 + others * size / 2 + others * others / 2);
    if (operations > kOperationsMax) return false;
    for (const uint32_t other : neighbours_[group]) {
      waiting.erase({rows_around(other), other});
      merged_.clear();
      std::set_union(neighbours_[other].begin(), neighbours_[other].end(), neighbours_[group].begin(),
                     neighbours_[group].end(), std::back_inserter(merged_));
      std::erase_if(merged_, [&](uint32_t each) { return each == group || each == other; });
      neighbours_[other] = merged_;
    }
    for (const uint32_t other : neighbours_[group]) waiting.emplace(rows_around(other), other);
  }
  return true;
}

void RowPlan::Place() {
  value_count_ = 0;
  links_.clear();
  first_link_.clear();
  diagonals_.clear();
  for (uint32_t g = 0; g < groups_.size(); ++g) {
    diagonals_.push_back(value_count_);
    value_count_ += size_t{groups_[g].size} * groups_[g].size;
    std::ranges::sort(neighbours_[g], {}, [&](uint32_t other) { return positions_[other]; });
    first_link_.push_back(links_.size());
    for (const uint32_t other : neighbours_[g]) {
      links_.push_back({other, value_count_});
      value_count_ += size_t{groups_[other].size} * groups_[g].size;
    }
  }
  first_link_.push_back(links_.size());
}

size_t RowPlan::BlockOf(uint32_t later, uint32_t earlier) const {
  if (later == earlier) return diagonals_[later];
  const std::span<const Link> candidates = links(earlier);
  return std::ranges::find(candidates, later, &Link::group)->block;
}

void RowPlan::FindTargets() {
  targets_.clear();
  first_target_.clear();
  for (uint32_t g = 0; g < groups_.size(); ++g) {
    first_target_.push_back(targets_.size());
    const std::span<const Link> around = links(g);
    for (size_t b = 0; b < around.size(); ++b) {
      for (size_t a = 0; a <= b; ++a) targets_.push_back(BlockOf(around[b].group, around[a].group));
    }
  }
  first_target_.push_back(targets_.size());
}

void RowPlan::FindCouplings() {
  couplings_.clear();
  for (const auto& holders : holders_) {
    for (size_t i = 0; i < holders.size(); ++i) {
      for (size_t j = 0; j <= i; ++j) {
        auto later = holders[i], earlier = holders[j];
        if (positions_[later.first] < positions_[earlier.first]) std::swap(later, earlier);
        couplings_.push_back(
            {later.first, earlier.first, later.second, earlier.second, BlockOf(later.first, earlier.first)});
      }
    }
  }
}

}  // namespace genphys

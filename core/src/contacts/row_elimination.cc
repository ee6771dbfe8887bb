#include "contacts/row_elimination.h"

#include <cmath>
#include <utility>

namespace genphys {

bool RowElimination::Begin(std::span<const Sides> rows, size_t bodies) {
  groups_.clear();
  holders_.clear();
  group_of_.clear();
  first_holder_.assign(bodies, kNone);
  for (const Sides& sides : rows) {
    group_of_.push_back(GroupOf(sides));
    ++groups_[group_of_.back()].rows.size;
  }
  planned_.clear();
  for (const Group& group : groups_) planned_.push_back(group.rows);
  if (!plan_.Make(planned_)) return false;
  uint32_t first = 0;
  for (const uint32_t number : plan_.order()) {
    groups_[number].first = first;
    first += groups_[number].rows.size;
  }
  order_.resize(rows.size());
  for (uint32_t row = 0; row < rows.size(); ++row) order_[groups_[group_of_[row]].first++] = row;
  for (Group& group : groups_) group.first -= group.rows.size;
  return true;
}

// It is looked for at the first of its bodies.
uint32_t RowElimination::GroupOf(Sides sides) {
  if (sides.b < sides.a) std::swap(sides.a, sides.b);
  const bool is_still = sides.a == RowPlan::kStill;
  for (uint32_t i = is_still ? kNone : first_holder_[sides.a]; i != kNone; i = holders_[i].next) {
    if (groups_[holders_[i].group].rows.bodies[1] == sides.b) return holders_[i].group;
  }
  const auto added = static_cast<uint32_t>(groups_.size());
  groups_.push_back({.rows = {.size = 0, .bodies = {sides.a, sides.b}}});
  if (is_still) return added;
  holders_.push_back({added, std::exchange(first_holder_[sides.a], static_cast<uint32_t>(holders_.size()))});
  return added;
}

void RowElimination::Choose(std::span<const uint8_t> is_chosen) {
  numbers_.assign(order_.size(), kNone);
  uint32_t number = 0;
  for (const uint32_t each : plan_.order()) {
    Group& group = groups_[each];
    group.begin = number;
    for (uint32_t i = group.first; i < group.first + group.rows.size; ++i) {
      if (is_chosen[i]) numbers_[i] = number++;
    }
    group.end = number;
  }
  size_ = number;
  if (matrix_.rows() < size_) matrix_.resize(size_, size_);
  FindRanges();
  Clear();
}

void RowElimination::FindRanges() {
  ranges_.clear();
  for (const uint32_t each : plan_.order()) {
    Group& group = groups_[each];
    group.first_range = static_cast<uint32_t>(ranges_.size());
    for (const RowPlan::Link& link : plan_.links(each)) {
      const Group& later = groups_[link.group];
      if (later.begin == later.end) continue;
      if (ranges_.size() > group.first_range && ranges_.back().end == later.begin) {
        ranges_.back().end = later.end;
      } else {
        ranges_.push_back({later.begin, later.end});
      }
    }
    group.range_count = static_cast<uint32_t>(ranges_.size()) - group.first_range;
  }
}

// Of the matrix that alone which elimination looks at.
void RowElimination::Clear() {
  for (const Group& group : groups_) {
    const uint32_t own = group.end - group.begin;
    if (own == 0) continue;
    matrix_.block(group.begin, group.begin, own, own).setZero();
    for (const auto& [begin, end] : RangesOf(group)) {
      matrix_.block(group.begin, begin, own, end - begin).setZero();
      matrix_.block(begin, group.begin, end - begin, own).setZero();
    }
  }
}

bool RowElimination::Factor() {
  inverse_pivots_.resize(size_);
  const Eigen::Index stride = matrix_.rows();
  for (const uint32_t each : plan_.order()) {
    const Group& group = groups_[each];
    const std::span<const Range> later = RangesOf(group);
    for (uint32_t pivot = group.begin; pivot < group.end; ++pivot) {
      const double* const from = matrix_.data() + pivot * stride;
      if (!(std::abs(from[pivot]) > 0)) return false;
      inverse_pivots_[pivot] = 1 / from[pivot];
      const auto eliminate_from = [&](uint32_t row) {
        double* const to = matrix_.data() + row * stride;
        const double part = to[pivot] *= inverse_pivots_[pivot];
        if (part == 0) return;
        for (uint32_t i = pivot + 1; i < group.end; ++i) to[i] -= part * from[i];
        for (const auto& [begin, end] : later) {
          for (uint32_t i = begin; i < end; ++i) to[i] -= part * from[i];
        }
      };
      for (uint32_t row = pivot + 1; row < group.end; ++row) eliminate_from(row);
      for (const auto& [begin, end] : later) {
        for (uint32_t row = begin; row < end; ++row) eliminate_from(row);
      }
    }
  }
  return true;
}

void RowElimination::Solve(Eigen::VectorXd& values) const {
  const auto visit_after = [&](const Group& group, uint32_t pivot, auto visit) {
    for (uint32_t i = pivot + 1; i < group.end; ++i) visit(i);
    for (const auto& [begin, end] : RangesOf(group)) {
      for (uint32_t i = begin; i < end; ++i) visit(i);
    }
  };
  const std::span<const uint32_t> order = plan_.order();
  for (const uint32_t each : order) {
    const Group& group = groups_[each];
    for (uint32_t pivot = group.begin; pivot < group.end; ++pivot) {
      const double value = values[pivot];
      visit_after(group, pivot, [&](uint32_t row) { values[row] -= matrix_(pivot, row) * value; });
    }
  }
  for (size_t i = order.size(); i-- > 0;) {
    const Group& group = groups_[order[i]];
    for (uint32_t pivot = group.end; pivot-- > group.begin;) {
      double value = values[pivot];
      visit_after(group, pivot, [&](uint32_t column) { value -= matrix_(column, pivot) * values[column]; });
      values[pivot] = value * inverse_pivots_[pivot];
    }
  }
}

}  // namespace genphys

#include "genphys/islands.h"

#include <algorithm>
#include <numeric>

namespace genphys {

namespace {

// A sensor holds nothing, nor does a gap that the solve leaves alone.
bool IsHeldBy(const ContactBuffer& contacts, const ContactPair& pair) {
  if (pair.is_sensor) return false;
  const auto first = contacts.points.begin() + pair.first_point;
  return !std::all_of(first, first + pair.point_count, [](const ContactPoint& point) { return point.is_ahead; });
}

// Whether the two part, so that they are nothing to each other in the step. What comes nearer may meet within it.
bool Parts(const ContactBuffer& contacts, const ContactPair& pair) {
  const auto first = contacts.points.begin() + pair.first_point;
  return std::all_of(first, first + pair.point_count, [](const ContactPoint& point) {
    return point.is_ahead && point.relative_velocity.dot(point.normal) > 0;
  });
}

}  // namespace

void Islands::Find(uint32_t row_count, std::span<const EntityRow> rows, const ContactBuffer& contacts,
                   std::span<const JointRow> joint_rows) {
  if (IsAsBefore(row_count, rows, contacts, joint_rows)) return;
  are_of_contacts_ = !contacts.pairs.empty();
  joined_.clear();
  for (const JointRow& row : joint_rows) joined_.emplace_back(row.a, row.b);
  for (EntityRow row : rows_) parents_[Index(row)] = numbers_[Index(row)] = kNone;
  parents_.resize(row_count, kNone);
  held_.resize(row_count);
  numbers_.resize(row_count, kNone);
  islands_.clear();
  rows_.assign(rows.begin(), rows.end());
  for (EntityRow row : rows) held_[Index(row)] = false;
  for (EntityRow row : rows) parents_[Index(row)] = Index(row);
  for (const ContactPair& pair : contacts.pairs) {
    if (IsHeldBy(contacts, pair)) Hold(pair.entity_a, pair.entity_b);
  }
  for (const JointRow& row : joint_rows) Hold(row.a, row.b);

  for (EntityRow row : rows) {
    if (!held_[Index(row)]) continue;
    // The root is the smallest row of its island, so that it has its number first.
    uint32_t& number = numbers_[RootOf(Index(row))];
    if (number == kNone) {
      number = static_cast<uint32_t>(islands_.size());
      islands_.emplace_back();
    }
    numbers_[Index(row)] = number;
  }
  for (const ContactPair& pair : contacts.pairs) {
    const uint32_t island = IslandOf(pair.entity_a, pair.entity_b);
    if (pair.is_sensor || island == kNone || Parts(contacts, pair)) continue;
    islands_[island].contacts += pair.point_count;
  }
  for (const JointRow& row : joint_rows) {
    const uint32_t island = IslandOf(row.a, row.b);
    if (island != kNone) ++islands_[island].joint_rows;
  }
  ListMembers(contacts, joint_rows);
}

bool Islands::IsAsBefore(uint32_t row_count, std::span<const EntityRow> rows, const ContactBuffer& contacts,
                         std::span<const JointRow> joint_rows) const {
  if (are_of_contacts_ || !contacts.pairs.empty() || parents_.size() != row_count) return false;
  const auto is_joined = [](const std::pair<EntityRow, EntityRow>& sides, const JointRow& row) {
    return sides.first == row.a && sides.second == row.b;
  };
  return std::ranges::equal(rows_, rows) && std::ranges::equal(joined_, joint_rows, is_joined);
}

template <typename T>
template <typename Visit>
void Islands::Lists<T>::Sort(size_t islands, const Visit& visit) {
  begins.assign(islands + 1, 0);
  visit([&](uint32_t island, T) { ++begins[island + 1]; });
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  members.resize(begins.back());
  visit([&](uint32_t island, T member) { members[begins[island]++] = member; });
  // Each begin is now that of the next one.
  std::shift_right(begins.begin(), begins.end(), 1);
  begins[0] = 0;
}

void Islands::ListMembers(const ContactBuffer& contacts, std::span<const JointRow> joint_rows) {
  held_rows_.Sort(islands_.size(), [&](auto add) {
    for (const EntityRow row : rows_) {
      if (held_[Index(row)]) add(numbers_[Index(row)], row);
    }
  });
  pairs_.Sort(islands_.size(), [&](auto add) {
    for (uint32_t i = 0; i < contacts.pairs.size(); ++i) {
      const uint32_t island = IslandOf(contacts.pairs[i].entity_a, contacts.pairs[i].entity_b);
      if (island != kNone && IsHeldBy(contacts, contacts.pairs[i])) add(island, i);
    }
  });
  joint_rows_.Sort(islands_.size(), [&](auto add) {
    for (uint32_t i = 0; i < joint_rows.size(); ++i) {
      const uint32_t island = IslandOf(joint_rows[i].a, joint_rows[i].b);
      if (island != kNone) add(island, i);
    }
  });
}

uint32_t Islands::RootOf(uint32_t row) {
  while (parents_[row] != row) row = parents_[row] = parents_[parents_[row]];
  return row;
}

void Islands::Hold(EntityRow a, EntityRow b) {
  const auto is_movable = [&](EntityRow row) { return Index(row) < parents_.size() && parents_[Index(row)] != kNone; };
  const bool a_moves = is_movable(a), b_moves = is_movable(b);
  if (a_moves) held_[Index(a)] = true;
  if (b_moves) held_[Index(b)] = true;
  if (!a_moves || !b_moves) return;
  const uint32_t root_a = RootOf(Index(a)), root_b = RootOf(Index(b));
  parents_[std::max(root_a, root_b)] = std::min(root_a, root_b);
}

}  // namespace genphys

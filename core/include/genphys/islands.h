#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "genphys/contact.h"
#include "genphys/joint_row.h"

namespace genphys {

/// Which bodies of a solve feel each other: those that contacts or rows of joints hold together, directly or through
/// other bodies that can be moved.
class Islands {
 public:
  static constexpr uint32_t kNone = ~uint32_t{0};

  struct Island {
    size_t contacts = 0;  // points
    size_t joint_rows = 0;
  };

  /// Finds the islands of the movable `rows` of a world of `row_count`. Those that nothing holds are in none.
  void Find(uint32_t row_count, std::span<const EntityRow> rows, const ContactBuffer& contacts,
            std::span<const JointRow> joint_rows);

  /// By number of the island, in order of their first rows.
  const std::vector<Island>& islands() const { return islands_; }

  /// The bodies of an island, ascending.
  std::span<const EntityRow> RowsOf(uint32_t island) const { return held_rows_.Of(island); }
  /// The numbers of the contact pairs that hold it, ascending.
  std::span<const uint32_t> PairsOf(uint32_t island) const { return pairs_.Of(island); }
  /// The same of the rows of its joints.
  std::span<const uint32_t> JointRowsOf(uint32_t island) const { return joint_rows_.Of(island); }

  uint32_t IslandOf(EntityRow row) const { return Index(row) < numbers_.size() ? numbers_[Index(row)] : kNone; }
  /// Of a pair of which one side at least can be moved.
  uint32_t IslandOf(EntityRow a, EntityRow b) const {
    const uint32_t island = IslandOf(a);
    return island != kNone ? island : IslandOf(b);
  }

 private:
  // Members of all islands, one island after the other.
  template <typename T>
  struct Lists {
    std::vector<uint32_t> begins{};  // by island, and the end of the last one
    std::vector<T> members{};

    std::span<const T> Of(uint32_t island) const {
      return std::span(members).subspan(begins[island], begins[island + 1] - begins[island]);
    }
    // visit(add) calls add(island, member) for each member, in order; it is called twice, to count them first.
    template <typename Visit>
    void Sort(size_t islands, const Visit& visit);
  };

  // Whether the last Find() was of the same, of which nothing but joints holds any.
  bool IsAsBefore(uint32_t row_count, std::span<const EntityRow> rows, const ContactBuffer& contacts,
                  std::span<const JointRow> joint_rows) const;
  void ListMembers(const ContactBuffer& contacts, std::span<const JointRow> joint_rows);
  uint32_t RootOf(uint32_t row);
  void Hold(EntityRow a, EntityRow b);

  // By row, of the last solve's rows only. A row that cannot be moved has no parent.
  std::vector<uint32_t> parents_;
  std::vector<uint8_t> held_;
  std::vector<uint32_t> numbers_;
  std::vector<Island> islands_;
  std::vector<EntityRow> rows_;
  std::vector<std::pair<EntityRow, EntityRow>> joined_;  // by row of a joint
  bool are_of_contacts_ = false;
  Lists<EntityRow> held_rows_;
  Lists<uint32_t> pairs_;
  Lists<uint32_t> joint_rows_;
};

}  // namespace genphys

#pragma once
#include <cstdint>
#include <span>
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

  uint32_t IslandOf(EntityRow row) const { return Index(row) < numbers_.size() ? numbers_[Index(row)] : kNone; }
  /// Of a pair of which one side at least can be moved.
  uint32_t IslandOf(EntityRow a, EntityRow b) const {
    const uint32_t island = IslandOf(a);
    return island != kNone ? island : IslandOf(b);
  }

 private:
  uint32_t RootOf(uint32_t row);
  void Hold(EntityRow a, EntityRow b);

  // By row, of the last solve's rows only. A row that cannot be moved has no parent.
  std::vector<uint32_t> parents_;
  std::vector<uint8_t> held_;
  std::vector<uint32_t> numbers_;
  std::vector<Island> islands_;
  std::vector<EntityRow> rows_;
};

}  // namespace genphys

#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace genphys {

/// In what order the rows of an island are eliminated, and where the numbers that belong to it are kept. Rows that
/// follow each other between the same two bodies form a group; groups feel each other through the bodies that they
/// share, and what is eliminated makes those around it feel each other. The group that feels the fewest rows goes
/// first (minimum degree: Tinney and Walker, Proc. IEEE 55, 1967), so that chains and trees cost in proportion to
/// their length.
class RowPlan {
 public:
  static constexpr uint32_t kStill = ~uint32_t{0};

  struct Group {
    uint32_t size = 0;                 // rows
    std::array<uint32_t, 2> bodies{};  // any numbers; kStill: cannot be moved
    bool operator==(const Group&) const = default;
  };

  /// A group that is eliminated later and feels this one.
  struct Link {
    uint32_t group = 0;
    size_t block = 0;  // of its size times the size of the earlier one, row by row
  };

  /// Two groups, or twice the same, that feel each other through one body.
  struct Coupling {
    uint32_t later = 0;
    uint32_t earlier = 0;
    uint8_t side_of_later = 0;
    uint8_t side_of_earlier = 0;
    size_t block = 0;
  };

  /// Plans for these groups, unless that is what it did the last time. False: it would take more than
  /// kOperationsMax.
  bool Make(std::span<const Group> groups);

  std::span<const uint32_t> order() const { return order_; }
  std::span<const Link> links(uint32_t group) const {
    return std::span(links_).subspan(first_link_[group], first_link_[group + 1] - first_link_[group]);
  }
  std::span<const Coupling> couplings() const { return couplings_; }
  /// Where the square block of a group is.
  size_t diagonal(uint32_t group) const { return diagonals_[group]; }
  /// Where the blocks are that the elimination of `group` changes: for each of its links b, for each a up to b.
  std::span<const size_t> targets(uint32_t group) const {
    return std::span(targets_).subspan(first_target_[group], first_target_[group + 1] - first_target_[group]);
  }
  size_t value_count() const { return value_count_; }

 private:
  // Multiplications; as many as a few hundred sweeps over so many rows as give them in a chain.
  static constexpr double kOperationsMax = 5e6;

  bool FindNeighbours();
  bool Eliminate();
  void Place();
  void FindTargets();
  void FindCouplings();
  size_t BlockOf(uint32_t later, uint32_t earlier) const;

  std::vector<Group> groups_;
  bool is_cheap_ = false;
  std::vector<uint32_t> order_;
  std::vector<uint32_t> positions_;  // in the order, by group
  std::vector<std::vector<uint32_t>> neighbours_;
  std::vector<std::vector<std::pair<uint32_t, uint8_t>>> holders_;  // groups and their sides, by body
  std::vector<uint32_t> merged_;
  std::vector<Link> links_;
  std::vector<size_t> first_link_;
  std::vector<size_t> targets_;
  std::vector<size_t> first_target_;
  std::vector<size_t> diagonals_;
  std::vector<Coupling> couplings_;
  size_t value_count_ = 0;
};

}  // namespace genphys

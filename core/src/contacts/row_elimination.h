#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "joints/row_plan.h"

namespace genphys {

/// Equations of rows between bodies, of which each has to do with those that share a body with it alone. They are
/// solved by elimination without a search for pivots, in the order of a RowPlan, so that trees take as long as they
/// have rows. Some of the rows may be left out, which changes from time to time.
class RowElimination {
 public:
  static constexpr uint32_t kNone = ~uint32_t{0};

  /// What a row acts on; RowPlan::kStill: something that nothing moves.
  struct Sides {
    uint32_t a, b;
  };

  /// Starts anew, with these rows between so many bodies. False: they would take too long.
  bool Begin(std::span<const Sides> rows, size_t bodies);

  /// All rows in their order: those between the same two bodies stay in the one in which they were given.
  std::span<const uint32_t> order() const { return order_; }

  /// Has equations of those rows alone that are chosen, by their place in order(), with nothing but zeros.
  void Choose(std::span<const uint8_t> is_chosen);
  /// How many there are.
  Eigen::Index size() const { return size_; }
  /// The number of each of order() among them, or kNone.
  std::span<const uint32_t> numbers() const { return numbers_; }

  /// The coefficient of a column in the equation of a row, by the numbers of two that share a body.
  double& At(uint32_t row, uint32_t column) { return matrix_(column, row); }

  /// Factors the equations as they are. False: they are singular.
  bool Factor();
  /// Turns the right sides of the factored equations into what solves them.
  void Solve(Eigen::VectorXd& values) const;

 private:
  struct Range {
    uint32_t begin, end;
  };
  // All rows between two bodies.
  struct Group {
    RowPlan::Group rows;
    uint32_t first = 0;                         // of order_
    uint32_t begin = 0, end = 0;                // of its chosen rows
    uint32_t first_range = 0, range_count = 0;  // of ranges_: the chosen rows that feel it and come later
  };
  // A group at a body, and the next one there.
  struct Holder {
    uint32_t group, next;
  };

  uint32_t GroupOf(Sides sides);
  std::span<const Range> RangesOf(const Group& group) const {
    return std::span(ranges_).subspan(group.first_range, group.range_count);
  }
  void FindRanges();
  void Clear();

  RowPlan plan_;
  std::vector<Group> groups_;
  std::vector<RowPlan::Group> planned_;  // the same as the plan wants them
  std::vector<uint32_t> group_of_;       // by row
  std::vector<Holder> holders_;
  std::vector<uint32_t> first_holder_;  // by body
  std::vector<uint32_t> order_;
  Eigen::Index size_ = 0;
  std::vector<uint32_t> numbers_;
  std::vector<Range> ranges_;
  Eigen::MatrixXd matrix_;  // each equation is a column, whose elements follow each other
  Eigen::VectorXd inverse_pivots_;
};

}  // namespace genphys

#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "genphys/row_marks.h"
#include "pairs/disjoint_sets.h"

namespace genphys {

/// How many impacts of one moment there are among bodies that hang together, each near the next one. What depends on
/// that does not depend on who collides elsewhere.
class Crowds {
 public:
  /// `numbers` is memory, which is empty before and after.
  explicit Crowds(RowValues<int>& numbers) : numbers_(numbers) {}
  ~Crowds() { numbers_.Clear(); }
  Crowds(const Crowds&) = delete;
  Crowds& operator=(const Crowds&) = delete;

  /// These two hang together.
  void Join(EntityRow a, EntityRow b) { sets_.Join(NumberOf(a), NumberOf(b)); }

  /// One of them has an impact more.
  void Count(EntityRow row) {
    const uint32_t number = NumberOf(row);
    counts_.resize(sets_.size());
    ++counts_[sets_.Find(number)];
  }

  /// Impacts of whom it hangs together with, and its own.
  size_t Of(EntityRow row) {
    const int number = std::as_const(numbers_)[row];
    return number < 0 || counts_.empty() ? 0 : counts_[sets_.Find(static_cast<uint32_t>(number))];
  }

  /// They are counted anew; who hangs together does still.
  void StartCount() { counts_.assign(sets_.size(), 0); }

  bool empty() const { return sets_.size() == 0; }
  void Clear() {
    numbers_.Clear();
    sets_ = DisjointSets(0);
    counts_.clear();
  }

 private:
  uint32_t NumberOf(EntityRow row) {
    int& number = numbers_[row];
    if (number < 0) number = static_cast<int>(sets_.Add());
    return static_cast<uint32_t>(number);
  }

  RowValues<int>& numbers_;
  DisjointSets sets_{0};
  std::vector<size_t> counts_;  // by root
};

}  // namespace genphys

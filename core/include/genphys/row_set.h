#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace genphys {

/// A set of rows, one bit each: looking through all of very many costs a hundredth of a nanosecond for each.
class RowSet {
 public:
  static constexpr size_t kRowsPerWord = 64;

  void Add(uint32_t row) {
    if (words_.size() <= row / kRowsPerWord) words_.resize(row / kRowsPerWord + 1);
    words_[row / kRowsPerWord] |= BitOf(row);
  }
  void Add(const RowSet& others);
  /// All below `rows`.
  void AddAll(uint32_t rows);
  void Remove(uint32_t row) {
    if (row / kRowsPerWord < words_.size()) words_[row / kRowsPerWord] &= ~BitOf(row);
  }
  void Clear() { words_.clear(); }
  bool operator[](uint32_t row) const {
    return row / kRowsPerWord < words_.size() && (words_[row / kRowsPerWord] & BitOf(row)) != 0;
  }

  /// Calls `visit(row)` for each, in ascending order.
  template <typename Visit>
  void ForEach(Visit visit) const {
    for (size_t i = 0; i < words_.size(); ++i) VisitWord(i, words_[i], visit);
  }
  /// The same for those that are in both.
  template <typename Visit>
  static void ForEachOfBoth(const RowSet& a, const RowSet& b, Visit visit) {
    const size_t words = a.words_.size() < b.words_.size() ? a.words_.size() : b.words_.size();
    for (size_t i = 0; i < words; ++i) VisitWord(i, a.words_[i] & b.words_[i], visit);
  }

 private:
  static uint64_t BitOf(uint32_t row) { return uint64_t{1} << (row % kRowsPerWord); }
  template <typename Visit>
  static void VisitWord(size_t at, uint64_t word, Visit visit) {
    for (; word != 0; word &= word - 1) {
      visit(static_cast<uint32_t>(at * kRowsPerWord) + static_cast<uint32_t>(std::countr_zero(word)));
    }
  }

  std::vector<uint64_t> words_;
};

}  // namespace genphys

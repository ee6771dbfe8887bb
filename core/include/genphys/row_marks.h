#pragma once
#include <cstdint>
#include <vector>

#include "genphys/ids.h"

namespace genphys {

/// Marks on some of very many rows: they cost by their own number, and nothing for all the other rows.
class RowMarks {
 public:
  /// Makes room for so many rows.
  void Resize(uint32_t rows) {
    if (marks_.size() < rows) marks_.resize(rows);
  }
  void Mark(EntityRow row) {
    if (marks_[Index(row)]) return;
    marks_[Index(row)] = true;
    rows_.push_back(row);
  }
  void Unmark(EntityRow row) { marks_[Index(row)] = false; }
  void Set(EntityRow row, bool on) { on ? Mark(row) : Unmark(row); }
  bool operator[](EntityRow row) const { return marks_[Index(row)] != 0; }
  /// Whether none was marked since all marks were taken away.
  bool empty() const { return rows_.empty(); }
  /// Takes all marks away.
  void Clear() {
    for (const EntityRow row : rows_) marks_[Index(row)] = false;
    rows_.clear();
  }

 private:
  std::vector<uint8_t> marks_;   // by row
  std::vector<EntityRow> rows_;  // that were marked, maybe more than once
};

/// Values of some of very many rows, at the same cost; all others have one and the same.
template <typename T>
class RowValues {
 public:
  explicit RowValues(const T& none) : none_(none) {}
  /// Makes room for so many rows.
  void Resize(uint32_t rows) {
    if (values_.size() < rows) values_.resize(rows, none_);
    set_.Resize(rows);
  }
  T& operator[](EntityRow row) {
    if (!set_[row]) rows_.push_back(row);
    set_.Mark(row);
    return values_[Index(row)];
  }
  const T& operator[](EntityRow row) const { return values_[Index(row)]; }
  bool empty() const { return rows_.empty(); }
  /// Takes all of them back.
  void Clear() {
    for (const EntityRow row : rows_) values_[Index(row)] = none_;
    rows_.clear();
    set_.Clear();
  }

 private:
  T none_;
  std::vector<T> values_;  // by row
  std::vector<EntityRow> rows_;
  RowMarks set_;
};

}  // namespace genphys

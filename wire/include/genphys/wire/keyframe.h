#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "genphys/ids.h"
#include "genphys/row_set.h"
#include "genphys/state.h"
#include "genphys/v1/frame.pb.h"

namespace genphys {

/// What the rows of a whole frame were like, so that a later frame can be told by those that differ.
class Keyframe {
 public:
  /// As `request` wants it of `state`, at `step`.
  Keyframe(const StateArrays& state, const v1::FrameRequest& request, uint64_t id, uint64_t step);

  uint64_t id() const { return id_; }
  uint64_t step() const { return step_; }
  size_t rows() const { return ids_.size(); }
  /// What it takes in memory.
  size_t bytes() const;

  /// Whether `request` would still have the same entities in the same rows.
  bool HasRowsOf(const StateArrays& state, const v1::FrameRequest& request) const;

  /// These may be other than they were. What was not told is taken to be the same.
  void MayDiffer(const RowSet& rows) { candidates_.Add(rows); }
  /// Rows of the frame that are other now, in ascending order of their ids. Costs what may differ.
  std::vector<uint32_t> Differing(const StateArrays& state) const;

 private:
  struct Column {
    const StateArrays::Columns3 StateArrays::*three = nullptr;
    const StateArrays::Columns4 StateArrays::*four = nullptr;
    std::vector<double> values;  // by row of the state
  };
  const double* ValuesOf(const StateArrays& state, const Column& column) const;
  bool Differs(const StateArrays& state, uint32_t row) const;

  const uint64_t id_;
  const uint64_t step_;
  std::vector<EntityId> ids_;
  std::vector<uint32_t> order_;  // empty: rows are in the order of ids
  RowSet members_;
  RowSet candidates_;
  std::vector<Column> columns_;
  std::vector<uint8_t> asleep_;
};

}  // namespace genphys

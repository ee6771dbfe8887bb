#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "genphys/state.h"
#include "genphys/v1/frame.pb.h"

namespace genphys {

/// The rows of the state that a whole frame has, in ascending order of their ids.
struct FrameRows {
  size_t count = 0;
  std::vector<uint32_t> rows;  // empty: the first `count`

  uint32_t row(size_t i) const { return rows.empty() ? static_cast<uint32_t>(i) : rows[i]; }
};

/// The living entities that `request` names, or all.
FrameRows ChooseRows(const StateArrays& state, const v1::FrameRequest& request);

}  // namespace genphys

#include "genphys/wire/keyframe.h"

#include <algorithm>
#include <cstring>

#include "frame_rows.h"

namespace genphys {
namespace {

std::vector<EntityId> IdsOf(const StateArrays& state, const FrameRows& rows) {
  std::vector<EntityId> ids(rows.count);
  for (size_t i = 0; i < rows.count; ++i) ids[i] = state.ids[rows.row(i)];
  return ids;
}

}  // namespace

Keyframe::Keyframe(const StateArrays& state, const v1::FrameRequest& request, uint64_t id, uint64_t step)
    : id_(id), step_(step), asleep_(state.asleep) {
  FrameRows rows = ChooseRows(state, request);
  ids_ = IdsOf(state, rows);
  for (size_t i = 0; i < rows.count; ++i) members_.Add(rows.row(i));
  if (!std::is_sorted(rows.rows.begin(), rows.rows.end())) order_ = std::move(rows.rows);
  const auto keep = [&](auto column) {
    const auto& values = state.*column;
    Column kept;
    if constexpr (std::is_same_v<decltype(column), const StateArrays::Columns3 StateArrays::*>) {
      kept.three = column;
    } else {
      kept.four = column;
    }
    kept.values.assign(values.data(), values.data() + values.size());
    columns_.push_back(std::move(kept));
  };
  using Three = const StateArrays::Columns3 StateArrays::*;
  using Four = const StateArrays::Columns4 StateArrays::*;
  if (request.poses()) keep(Three{&StateArrays::positions}), keep(Four{&StateArrays::orientations});
  if (request.velocities()) keep(Three{&StateArrays::linear_velocities}), keep(Three{&StateArrays::angular_velocities});
  if (request.net_forces()) keep(Three{&StateArrays::net_forces}), keep(Three{&StateArrays::net_torques});
}

size_t Keyframe::bytes() const {
  size_t bytes = ids_.size() * sizeof(EntityId) + order_.size() * sizeof(uint32_t) + asleep_.size();
  for (const Column& column : columns_) bytes += column.values.size() * sizeof(double);
  return bytes;
}

bool Keyframe::HasRowsOf(const StateArrays& state, const v1::FrameRequest& request) const {
  return IdsOf(state, ChooseRows(state, request)) == ids_;
}

const double* Keyframe::ValuesOf(const StateArrays& state, const Column& column) const {
  return column.three != nullptr ? (state.*column.three).data() : (state.*column.four).data();
}

bool Keyframe::Differs(const StateArrays& state, uint32_t row) const {
  if (state.asleep[row] != asleep_[row]) return true;
  return std::any_of(columns_.begin(), columns_.end(), [&](const Column& column) {
    const size_t width = column.three != nullptr ? 3 : 4;
    // Bit by bit: what is laid over the keyframe must be what is.
    return std::memcmp(ValuesOf(state, column) + row * width, column.values.data() + row * width,
                       width * sizeof(double)) != 0;
  });
}

std::vector<uint32_t> Keyframe::Differing(const StateArrays& state) const {
  std::vector<uint32_t> rows;
  RowSet::ForEachOfBoth(members_, candidates_, [&](uint32_t row) {
    if (Differs(state, row)) rows.push_back(row);
  });
  if (!order_.empty()) {
    std::sort(rows.begin(), rows.end(), [&](uint32_t a, uint32_t b) { return state.ids[a] < state.ids[b]; });
  }
  return rows;
}

}  // namespace genphys

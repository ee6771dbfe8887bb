#include "genphys/wire/keyframe.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "byte_flags.h"
#include "frame_rows.h"

namespace genphys {
namespace {

constexpr size_t kBytesPerWord = sizeof(uint64_t);

uint64_t LoadBytes(std::span<const uint8_t> bytes, size_t at) {
  uint64_t word = 0;
  if (at + kBytesPerWord <= bytes.size()) {
    // Of fixed size, so that it is one load.
    std::memcpy(&word, bytes.data() + at, kBytesPerWord);
  } else {
    std::memcpy(&word, bytes.data() + at, bytes.size() - at);
  }
  return word;
}

std::vector<EntityId> IdsOf(const StateArrays& state, const FrameRows& rows) {
  std::vector<EntityId> ids(rows.count);
  for (size_t i = 0; i < rows.count; ++i) ids[i] = state.ids[rows.row(i)];
  return ids;
}

}  // namespace

void RowSet::Add(uint32_t row) {
  if (words_.size() <= row / kRowsPerWord) words_.resize(row / kRowsPerWord + 1);
  words_[row / kRowsPerWord] |= uint64_t{1} << (row % kRowsPerWord);
}

void RowSet::AddAll(uint32_t rows) { words_.assign((rows + kRowsPerWord - 1) / kRowsPerWord, ~uint64_t{0}); }

void RowSet::Add(const RowSet& others) {
  if (words_.size() < others.words_.size()) words_.resize(others.words_.size());
  for (size_t i = 0; i < others.words_.size(); ++i) words_[i] |= others.words_[i];
}

void RowSet::AssignAwake(std::span<const uint8_t> asleep, std::span<const uint8_t> moves) {
  const size_t rows = std::min(asleep.size(), moves.size());
  words_.assign((rows + kRowsPerWord - 1) / kRowsPerWord, 0);
  for (size_t at = 0; at < rows; at += kBytesPerWord) {
    const uint64_t awake = LowestBits(~LoadBytes(asleep, at) & LoadBytes(moves, at));
    words_[at / kRowsPerWord] |= awake << (at % kRowsPerWord);
  }
}

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
  const auto members = members_.words(), candidates = candidates_.words();
  for (size_t i = 0; i < std::min(members.size(), candidates.size()); ++i) {
    for (uint64_t left = members[i] & candidates[i]; left != 0; left &= left - 1) {
      const auto row = static_cast<uint32_t>(i * RowSet::kRowsPerWord) + static_cast<uint32_t>(std::countr_zero(left));
      if (Differs(state, row)) rows.push_back(row);
    }
  }
  if (!order_.empty()) {
    std::sort(rows.begin(), rows.end(), [&](uint32_t a, uint32_t b) { return state.ids[a] < state.ids[b]; });
  }
  return rows;
}

}  // namespace genphys

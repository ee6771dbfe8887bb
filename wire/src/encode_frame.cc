#include "genphys/wire/encode_frame.h"

#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "byte_flags.h"
#include "frame_rows.h"
#include "genphys/wire/encode.h"
#include "genphys/wire/wire_format.h"
#include "values.h"

namespace genphys {
namespace {

template <typename Columns>
size_t WidthOf(const Columns& columns) {
  return static_cast<size_t>(columns.rows());
}

}  // namespace

void AppendStamp(const v1::WorldStamp& stamp, std::string& out) {
  AppendFieldHeader(v1::Frame::kStampFieldNumber, stamp.ByteSizeLong(), out);
  stamp.AppendToString(&out);
}

FrameEncoder::FrameEncoder(const StateArrays& state, const v1::FrameRequest& request, const World* joints_of,
                           const FrameNames& names, std::vector<uint32_t> delta_rows)
    : state_(state),
      scalar_(request.scalar() == v1::SCALAR_FLOAT32 ? v1::SCALAR_FLOAT32 : v1::SCALAR_FLOAT64),
      rows_(std::move(delta_rows)) {
  count_ = rows_.size();
  if (!names.keyframe_step) {
    FrameRows whole = ChooseRows(state, request);
    count_ = whole.count;
    rows_ = std::move(whole.rows);
  }
  ChooseColumns(request);
  MakeHead(names, joints_of);
  size_ = head_.size();
  const auto add = [&](int field, size_t bytes) {
    if (bytes > 0) size_ += FieldHeaderSize(field, bytes) + bytes;
  };
  add(v1::Frame::kEntityIdsFieldNumber, count_ * sizeof(EntityId));
  for (const Column& column : columns_) add(column.field, ColumnBytes(column));
  add(v1::Frame::kAsleepFieldNumber, (count_ + 7) / 8);
}

void FrameEncoder::ChooseColumns(const v1::FrameRequest& request) {
  const StateArrays& s = state_;
  const auto add = [&](int field, const auto& column) {
    columns_.push_back({.field = field, .first = column.data(), .first_width = WidthOf(column)});
  };
  if (request.poses()) {
    add(v1::Frame::kPositionsFieldNumber, s.positions);
    add(v1::Frame::kOrientationsFieldNumber, s.orientations);
  }
  if (request.velocities()) {
    add(v1::Frame::kLinearVelocitiesFieldNumber, s.linear_velocities);
    add(v1::Frame::kAngularVelocitiesFieldNumber, s.angular_velocities);
  }
  if (request.net_forces()) {
    columns_.push_back({.field = v1::Frame::kNetForcesFieldNumber,
                        .first = s.net_forces.data(),
                        .first_width = WidthOf(s.net_forces),
                        .second = s.net_torques.data(),
                        .second_width = WidthOf(s.net_torques)});
  }
}

void FrameEncoder::MakeHead(const FrameNames& names, const World* joints_of) {
  std::vector<EntityId> gathered;
  const EntityId* ids = state_.ids.data();
  if (!rows_.empty()) {
    gathered.reserve(count_);
    for (const uint32_t row : rows_) gathered.push_back(state_.ids[row]);
    ids = gathered.data();
  }
  v1::Frame head;
  head.set_scalar(scalar_);
  head.set_rows_id(XXH3_64bits(ids, count_ * sizeof(EntityId)));
  if (names.keyframe_id != 0) head.set_keyframe_id(names.keyframe_id);
  if (names.keyframe_step) head.set_keyframe_step(*names.keyframe_step);
  if (joints_of != nullptr) EncodeJointColumns(*joints_of, &head);
  head_ = head.SerializeAsString();
}

size_t FrameEncoder::ColumnBytes(const Column& column) const {
  const size_t scalar_bytes = scalar_ == v1::SCALAR_FLOAT32 ? sizeof(float) : sizeof(double);
  return count_ * (column.first_width + column.second_width) * scalar_bytes;
}

void FrameEncoder::WriteIds(char* to) const {
  if (rows_.empty()) {
    std::memcpy(to, state_.ids.data(), count_ * sizeof(EntityId));
    return;
  }
  for (const uint32_t row : rows_) {
    std::memcpy(to, &state_.ids[row], sizeof(EntityId));
    to += sizeof(EntityId);
  }
}

void FrameEncoder::WriteAsleep(char* to) const {
  size_t i = 0;
  if (rows_.empty()) {
    for (; i + 8 <= count_; i += 8, ++to) *to = static_cast<char>(LowestBits(&state_.asleep[i]));
  }
  for (; i < count_; i += 8, ++to) {
    unsigned bits = 0;
    for (size_t bit = 0; bit < std::min<size_t>(8, count_ - i); ++bit) {
      bits |= (state_.asleep[row(i + bit)] != 0 ? 1u : 0u) << bit;
    }
    *to = static_cast<char>(bits);
  }
}

template <typename Scalar>
void FrameEncoder::WriteColumn(const Column& column, char* to) const {
  if (std::is_same_v<Scalar, double> && rows_.empty() && column.second == nullptr) {
    std::memcpy(to, column.first, count_ * column.first_width * sizeof(double));
    return;
  }
  // The message is aligned for nothing but bytes, hence the copy of each scalar.
  const auto put = [&](const double* values, size_t width) {
    for (size_t i = 0; i < width; ++i, to += sizeof(Scalar)) {
      const auto scalar = static_cast<Scalar>(values[i]);
      std::memcpy(to, &scalar, sizeof(Scalar));
    }
  };
  for (size_t i = 0; i < count_; ++i) {
    put(column.first + row(i) * column.first_width, column.first_width);
    if (column.second != nullptr) put(column.second + row(i) * column.second_width, column.second_width);
  }
}

char* FrameEncoder::Write(char* to) const {
  to = std::copy(head_.begin(), head_.end(), to);
  const auto write = [&](int field, size_t bytes, auto write_payload) {
    if (bytes == 0) return;
    to = WriteFieldHeader(field, bytes, to);
    write_payload(to);
    to += bytes;
  };
  write(v1::Frame::kEntityIdsFieldNumber, count_ * sizeof(EntityId), [&](char* at) { WriteIds(at); });
  for (const Column& column : columns_) {
    write(column.field, ColumnBytes(column), [&](char* at) {
      if (scalar_ == v1::SCALAR_FLOAT32) {
        WriteColumn<float>(column, at);
      } else {
        WriteColumn<double>(column, at);
      }
    });
  }
  write(v1::Frame::kAsleepFieldNumber, (count_ + 7) / 8, [&](char* at) { WriteAsleep(at); });
  return to;
}

}  // namespace genphys

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "genphys/wire/encode.h"
#include "values.h"

namespace genphys {
namespace {

struct FrameRows {
  std::vector<uint32_t> rows;  // in ascending order of their ids
  bool consecutive = true;     // each row follows the one before it, so that columns can be copied whole
};

FrameRows RowsOfAll(const StateArrays& state) {
  FrameRows found;
  found.rows.reserve(state.rows());
  for (uint32_t row = 0; row < state.rows(); ++row) {
    if (!state.ids[row].is_null()) found.rows.push_back(row);
  }
  return found;
}

FrameRows RowsOf(const StateArrays& state, const google::protobuf::RepeatedField<uint64_t>& ids) {
  FrameRows found;
  found.rows.reserve(static_cast<size_t>(ids.size()));
  for (const uint64_t packed : ids) {
    const EntityId id = EntityId::FromPacked(packed);
    if (!id.is_null() && id.index() < state.rows() && state.ids[id.index()] == id) found.rows.push_back(id.index());
  }
  return found;
}

void Order(const StateArrays& state, FrameRows& found) {
  std::vector<uint32_t>& rows = found.rows;
  const auto less = [&](uint32_t a, uint32_t b) { return state.ids[a] < state.ids[b]; };
  if (!std::is_sorted(rows.begin(), rows.end(), less)) std::sort(rows.begin(), rows.end(), less);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  found.consecutive =
      std::adjacent_find(rows.begin(), rows.end(), [](uint32_t a, uint32_t b) { return b != a + 1; }) == rows.end();
}

// A column of the model: `width` scalars per row, one row behind the other.
struct Source {
  const double* data;
  size_t width;
};

template <typename Columns>
Source SourceOf(const Columns& columns) {
  return {columns.data(), static_cast<size_t>(columns.rows())};
}

/// Writes the rows of all `sources` side by side.
template <typename Scalar, size_t kSources>
void Pack(const FrameRows& from, const std::array<Source, kSources>& sources, std::string* out) {
  if (from.rows.empty()) return;
  if constexpr (kSources == 1 && std::is_same_v<Scalar, double>) {
    if (from.consecutive) {
      const auto [data, width] = sources[0];
      out->assign(reinterpret_cast<const char*>(data + from.rows.front() * width),
                  from.rows.size() * width * sizeof(double));
      return;
    }
  }
  size_t width = 0;
  for (const Source& source : sources) width += source.width;
  out->resize(from.rows.size() * width * sizeof(Scalar));
  // A string's first byte may be aligned for nothing but bytes, hence the copy of each scalar.
  char* to = out->data();
  for (const uint32_t row : from.rows) {
    for (const Source& source : sources) {
      const double* values = source.data + row * source.width;
      for (size_t i = 0; i < source.width; ++i, to += sizeof(Scalar)) {
        const auto scalar = static_cast<Scalar>(values[i]);
        std::memcpy(to, &scalar, sizeof(Scalar));
      }
    }
  }
}

template <typename Scalar>
void PackColumns(const StateArrays& state, const FrameRows& from, const v1::FrameRequest& request, v1::Frame* out) {
  const auto pack = [&](const auto& columns, std::string* bytes) { Pack<Scalar, 1>(from, {SourceOf(columns)}, bytes); };
  if (request.poses()) {
    pack(state.positions, out->mutable_positions());
    pack(state.orientations, out->mutable_orientations());
  }
  if (request.velocities()) {
    pack(state.linear_velocities, out->mutable_linear_velocities());
    pack(state.angular_velocities, out->mutable_angular_velocities());
  }
  if (request.net_forces()) {
    Pack<Scalar, 2>(from, {SourceOf(state.net_forces), SourceOf(state.net_torques)}, out->mutable_net_forces());
  }
}

void PackIds(const StateArrays& state, const FrameRows& from, std::string* out) {
  out->resize(from.rows.size() * sizeof(EntityId));
  char* to = out->data();
  for (const uint32_t row : from.rows) {
    std::memcpy(to, &state.ids[row], sizeof(EntityId));
    to += sizeof(EntityId);
  }
}

void PackAsleep(const StateArrays& state, const FrameRows& from, std::string* out) {
  out->assign((from.rows.size() + 7) / 8, '\0');
  for (size_t i = 0; i < from.rows.size(); ++i) {
    const int bit = (state.asleep[from.rows[i]] != 0 ? 1 : 0) << (i % 8);
    (*out)[i / 8] = static_cast<char>((*out)[i / 8] | bit);
  }
}

}  // namespace

void EncodeFrame(const StateArrays& state, const v1::FrameRequest& request, const v1::WorldStamp& stamp,
                 v1::Frame* out) {
  FrameRows from = request.entity_ids().empty() ? RowsOfAll(state) : RowsOf(state, request.entity_ids());
  Order(state, from);
  *out->mutable_stamp() = stamp;
  PackIds(state, from, out->mutable_entity_ids());
  out->set_rows_id(XXH3_64bits(out->entity_ids().data(), out->entity_ids().size()));
  PackAsleep(state, from, out->mutable_asleep());
  if (request.scalar() == v1::SCALAR_FLOAT32) {
    out->set_scalar(v1::SCALAR_FLOAT32);
    PackColumns<float>(state, from, request, out);
  } else {
    out->set_scalar(v1::SCALAR_FLOAT64);
    PackColumns<double>(state, from, request, out);
  }
}

}  // namespace genphys

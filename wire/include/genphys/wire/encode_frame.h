#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "genphys/state.h"
#include "genphys/v1/frame.pb.h"
#include "genphys/world.h"

namespace genphys {

/// Which keyframe a frame is, or which one it is against.
struct FrameNames {
  uint64_t keyframe_id = 0;               // zero: none
  std::optional<uint64_t> keyframe_step;  // set: it is a delta
};

/// Appends the field of a v1::Frame that says when it is true.
void AppendStamp(const v1::WorldStamp& stamp, std::string& out);

/// The living entities that a request names, or all, as columns in ascending order of id: an encoded v1::Frame that is
/// written where it is wanted, in one pass over the rows. It has no stamp, so that it stays true while nothing moves: a
/// field before it has that (AppendStamp). `state` and `request` stay as they are until it is written.
class FrameEncoder {
 public:
  /// Without joints.
  FrameEncoder(const StateArrays& state, const v1::FrameRequest& request)
      : FrameEncoder(state, request, nullptr, {}, {}) {}
  /// With the joints of the world, if they are asked for.
  FrameEncoder(const World& world, const v1::FrameRequest& request) : FrameEncoder(world, request, {}, {}) {}
  /// The same as a keyframe; or, against one, no more than `delta_rows` of the state, in ascending order of their ids.
  FrameEncoder(const World& world, const v1::FrameRequest& request, const FrameNames& names,
               std::vector<uint32_t> delta_rows)
      : FrameEncoder(world.state(), request, request.joints() ? &world : nullptr, names, std::move(delta_rows)) {}

  /// Bytes of the message.
  size_t size() const { return size_; }
  /// Writes the message to size() bytes at `to`, and returns where it ends.
  char* Write(char* to) const;

 private:
  FrameEncoder(const StateArrays& state, const v1::FrameRequest& request, const World* joints_of,
               const FrameNames& names, std::vector<uint32_t> delta_rows);

  // A column of the message: `width` scalars per row, of one or two columns of the model side by side.
  struct Column {
    int field = 0;
    const double* first = nullptr;
    size_t first_width = 0;
    const double* second = nullptr;
    size_t second_width = 0;
  };

  void ChooseColumns(const v1::FrameRequest& request);
  void MakeHead(const FrameNames& names, const World* joints_of);
  size_t row(size_t i) const { return rows_.empty() ? i : rows_[i]; }
  size_t ColumnBytes(const Column& column) const;
  void WriteIds(char* to) const;
  void WriteAsleep(char* to) const;
  template <typename Scalar>
  void WriteColumn(const Column& column, char* to) const;

  const StateArrays& state_;
  const v1::Scalar scalar_;
  size_t count_ = 0;
  std::vector<uint32_t> rows_;  // in ascending order of their ids; empty: the first count_, which a delta has none of
  std::vector<Column> columns_;
  std::string head_;  // all fields but the columns of entities
  size_t size_ = 0;
};

}  // namespace genphys

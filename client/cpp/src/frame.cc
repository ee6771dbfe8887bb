#include "genphys/client/frame.h"

#include <algorithm>
#include <string>
#include <utility>

#include "genphys/v1/frame.pb.h"

namespace genphys::client {
namespace {

// The bytes of a column are read where they lie: protobuf keeps each in a string of its own, which is aligned for them.
template <typename Columns>
Columns View(const std::string* bytes) {
  constexpr size_t kRowBytes = Columns::RowsAtCompileTime * sizeof(double);
  if (bytes == nullptr || bytes->empty()) return Columns(nullptr, Columns::RowsAtCompileTime, 0);
  return Columns(reinterpret_cast<const double*>(bytes->data()), Columns::RowsAtCompileTime,
                 static_cast<Eigen::Index>(bytes->size() / kRowBytes));
}

bool Fits(const std::string& bytes, size_t rows, size_t row_bytes) {
  return bytes.empty() || bytes.size() == rows * row_bytes;
}

}  // namespace

Stamp DecodeStamp(const v1::WorldStamp& stamp) {
  Stamp decoded{stamp.step(), stamp.simulation_time_seconds(), stamp.epoch(), std::nullopt};
  if (stamp.has_state_hash()) decoded.state_hash = stamp.state_hash();
  return decoded;
}

Result<Frame> Frame::Make(std::shared_ptr<const v1::Frame> message) {
  const v1::Frame& m = *message;
  const size_t rows = m.entity_ids().size() / sizeof(EntityId);
  constexpr size_t kScalar = sizeof(double);
  const size_t joints = m.joint_ids().size() / sizeof(JointId);
  const bool joints_fit = m.joint_ids().size() == joints * sizeof(JointId) &&
                          Fits(m.joint_positions(), joints, 6 * kScalar) &&
                          Fits(m.joint_rates(), joints, 6 * kScalar) && Fits(m.joint_forces(), joints, 6 * kScalar);
  const bool fits = joints_fit && m.scalar() == v1::SCALAR_FLOAT64 &&
                    m.entity_ids().size() == rows * sizeof(EntityId) && Fits(m.positions(), rows, 3 * kScalar) &&
                    Fits(m.orientations(), rows, 4 * kScalar) && Fits(m.linear_velocities(), rows, 3 * kScalar) &&
                    Fits(m.angular_velocities(), rows, 3 * kScalar) && Fits(m.net_forces(), rows, 6 * kScalar) &&
                    m.asleep().size() == (rows + 7) / 8;
  if (!fits) return absl::InternalError("the server sent a frame whose columns differ in length");
  Frame frame;
  frame.stamp_ = DecodeStamp(m.stamp());
  frame.rows_ = static_cast<uint32_t>(rows);
  frame.message_ = std::move(message);
  return frame;
}

std::span<const EntityId> Frame::ids() const {
  if (rows_ == 0) return {};
  return {reinterpret_cast<const EntityId*>(message_->entity_ids().data()), rows_};
}

std::optional<uint32_t> Frame::row(EntityId id) const {
  const std::span<const EntityId> all = ids();
  const auto found = std::lower_bound(all.begin(), all.end(), id);
  if (found == all.end() || *found != id) return std::nullopt;
  return static_cast<uint32_t>(found - all.begin());
}

Frame::Columns3 Frame::positions() const { return View<Columns3>(message_ ? &message_->positions() : nullptr); }

Frame::Columns4 Frame::orientations() const { return View<Columns4>(message_ ? &message_->orientations() : nullptr); }

Frame::Columns3 Frame::linear_velocities() const {
  return View<Columns3>(message_ ? &message_->linear_velocities() : nullptr);
}

Frame::Columns3 Frame::angular_velocities() const {
  return View<Columns3>(message_ ? &message_->angular_velocities() : nullptr);
}

std::span<const JointId> Frame::joint_ids() const {
  if (!message_ || message_->joint_ids().empty()) return {};
  return {reinterpret_cast<const JointId*>(message_->joint_ids().data()),
          message_->joint_ids().size() / sizeof(JointId)};
}

std::optional<uint32_t> Frame::joint_column(JointId id) const {
  const std::span<const JointId> all = joint_ids();
  const auto found = std::lower_bound(all.begin(), all.end(), id);
  if (found == all.end() || *found != id) return std::nullopt;
  return static_cast<uint32_t>(found - all.begin());
}

Frame::Columns6 Frame::joint_positions() const {
  return View<Columns6>(message_ ? &message_->joint_positions() : nullptr);
}

Frame::Columns6 Frame::joint_rates() const { return View<Columns6>(message_ ? &message_->joint_rates() : nullptr); }

Frame::Columns6 Frame::joint_forces() const { return View<Columns6>(message_ ? &message_->joint_forces() : nullptr); }

Frame::Columns6 Frame::net_forces() const { return View<Columns6>(message_ ? &message_->net_forces() : nullptr); }

bool Frame::asleep(uint32_t row) const { return ((message_->asleep()[row / 8] >> (row % 8)) & 1) != 0; }

Pose Frame::pose(uint32_t row) const { return {positions().col(row), FromColumn(orientations().col(row))}; }

uint64_t Frame::skipped_frames() const { return message_ ? message_->skipped_frames() : 0; }

}  // namespace genphys::client

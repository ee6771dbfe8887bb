#include "keyframes.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "genphys/ids.h"

namespace genphys::client {
namespace {

constexpr size_t kScalar = sizeof(double);

std::span<const EntityId> IdsIn(const v1::Frame& frame) {
  return {reinterpret_cast<const EntityId*>(frame.entity_ids().data()), frame.entity_ids().size() / sizeof(EntityId)};
}

// For each row of `delta` its row in `keyframe`. Nothing if it is not there; both are ascending.
Result<std::vector<size_t>> RowsIn(const v1::Frame& keyframe, const v1::Frame& delta) {
  const std::span<const EntityId> all = IdsIn(keyframe);
  std::vector<size_t> rows;
  auto place = all.begin();
  for (const EntityId id : IdsIn(delta)) {
    place = std::lower_bound(place, all.end(), id);
    if (place == all.end() || *place != id) return absl::InternalError("a delta has a row that its keyframe lacks");
    rows.push_back(static_cast<size_t>(place - all.begin()));
  }
  return rows;
}

// False when the columns do not fit the rows.
bool Lay(const std::string& delta, const std::vector<size_t>& rows, size_t width, std::string* whole) {
  if (whole->empty()) return delta.empty();
  const size_t row_bytes = width * kScalar;
  if (delta.size() != rows.size() * row_bytes) return false;
  for (size_t i = 0; i < rows.size(); ++i) {
    if ((rows[i] + 1) * row_bytes > whole->size()) return false;
    std::memcpy(whole->data() + rows[i] * row_bytes, delta.data() + i * row_bytes, row_bytes);
  }
  return true;
}

bool LayBits(const std::string& delta, const std::vector<size_t>& rows, std::string* whole) {
  if (delta.size() != (rows.size() + 7) / 8) return false;
  for (size_t i = 0; i < rows.size(); ++i) {
    if (rows[i] / 8 >= whole->size()) return false;
    const bool bit = ((delta[i / 8] >> (i % 8)) & 1) != 0;
    char& byte = (*whole)[rows[i] / 8];
    const int mask = 1 << (rows[i] % 8);
    byte = static_cast<char>(bit ? byte | mask : byte & ~mask);
  }
  return true;
}

}  // namespace

Result<FramePtr> WholeFrame(FramePtr received, const FramePtr& keyframe) {
  if (!received->has_keyframe_step()) return received;
  if (keyframe == nullptr || keyframe->keyframe_id() != received->keyframe_id()) {
    return absl::InternalError("the server sent a delta against a keyframe that it did not send");
  }
  const Result<std::vector<size_t>> rows = RowsIn(*keyframe, *received);
  if (!rows.ok()) return rows.status();
  auto whole = std::make_shared<v1::Frame>(*keyframe);
  const v1::Frame& delta = *received;
  const bool fits = Lay(delta.positions(), *rows, 3, whole->mutable_positions()) &&
                    Lay(delta.orientations(), *rows, 4, whole->mutable_orientations()) &&
                    Lay(delta.linear_velocities(), *rows, 3, whole->mutable_linear_velocities()) &&
                    Lay(delta.angular_velocities(), *rows, 3, whole->mutable_angular_velocities()) &&
                    Lay(delta.net_forces(), *rows, 6, whole->mutable_net_forces()) &&
                    LayBits(delta.asleep(), *rows, whole->mutable_asleep());
  if (!fits) return absl::InternalError("the server sent a delta whose columns differ in length");
  *whole->mutable_stamp() = delta.stamp();
  whole->set_skipped_frames(delta.skipped_frames());
  whole->set_joint_ids(delta.joint_ids());
  whole->set_joint_positions(delta.joint_positions());
  whole->set_joint_rates(delta.joint_rates());
  whole->set_joint_forces(delta.joint_forces());
  return FramePtr(std::move(whole));
}

std::string Keyframes::KeyOf(v1::FrameRequest wishes) {
  wishes.clear_keyframe_id();
  return wishes.SerializeAsString();
}

FramePtr Keyframes::Find(v1::FrameRequest* wishes) const {
  const std::lock_guard lock(mutex_);
  const auto found = last_.find(KeyOf(*wishes));
  if (found == last_.end()) return nullptr;
  wishes->set_keyframe_id(found->second->keyframe_id());
  return found->second;
}

void Keyframes::Keep(const v1::FrameRequest& wishes, const FramePtr& frame) {
  if (frame->keyframe_id() == 0 || frame->has_keyframe_step()) return;
  const std::lock_guard lock(mutex_);
  if (last_.size() >= kKindsMax) last_.clear();
  last_[KeyOf(wishes)] = frame;
}

}  // namespace genphys::client

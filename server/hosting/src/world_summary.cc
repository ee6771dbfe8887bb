#include "world_summary.h"

#include "genphys/wire/encode.h"

namespace genphys {
namespace {

// Of an id, and of pose, velocities and net force; of an id, and of position, rate and force of a joint.
constexpr size_t kEntityBytes = sizeof(uint64_t) + (7 + 6 + 6) * sizeof(double) + 1;
constexpr size_t kJointBytes = sizeof(uint64_t) + (6 + 6 + 6) * sizeof(double);

}  // namespace

void WorldSummary::Update(const World& world, const Stamp& stamp, v1::World::State state, bool is_left_alone) {
  const WorldDesc& desc = world.scene().world;
  frame_bytes_max_ = world.entity_count() * kEntityBytes + world.joint_count() * kJointBytes;
  const std::lock_guard lock(mutex_);
  // It seldom changes, and copies on the heap.
  if (!(desc == desc_)) desc_ = desc;
  stamp_ = stamp;
  state_ = state;
  is_left_alone_ = is_left_alone;
}

void WorldSummary::SetState(v1::World::State state) {
  const std::lock_guard lock(mutex_);
  state_ = state;
  is_left_alone_ = false;
}

bool WorldSummary::IsCurrent() const {
  const std::lock_guard lock(mutex_);
  return !is_left_alone_;
}

v1::GetWorldResponse WorldSummary::Tell() const {
  v1::GetWorldResponse response;
  const std::lock_guard lock(mutex_);
  EncodeWorld(desc_, name_, state_, response.mutable_world());
  response.mutable_world()->set_record_state_hash(record_state_hash_);
  stamp_.Encode(response.mutable_stamp());
  return response;
}

}  // namespace genphys

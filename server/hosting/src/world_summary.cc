#include "world_summary.h"

#include "genphys/wire/encode.h"

namespace genphys {

void WorldSummary::Update(const WorldDesc& desc, const Stamp& stamp, v1::World::State state, bool is_left_alone) {
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

#pragma once
#include <atomic>
#include <cstddef>
#include <mutex>
#include <string>
#include <utility>

#include "genphys/hosting/stamp.h"
#include "genphys/v1/world_service.pb.h"
#include "genphys/world.h"

namespace genphys {

/// What GetWorld tells of a world, kept beside it, so that who asks need not wait until a step ends. Thread-safe.
class WorldSummary {
 public:
  WorldSummary(std::string name, bool record_state_hash)
      : name_(std::move(name)), record_state_hash_(record_state_hash) {}

  /// How the world is now. `is_left_alone`: it plays, and does not take its steps when they are due.
  void Update(const World& world, const Stamp& stamp, v1::World::State state, bool is_left_alone);
  /// It does not play, wherever it is.
  void SetState(v1::World::State state);

  /// Whether the last update still tells how the world is, or else was before its present step.
  bool IsCurrent() const;
  /// The reply to GetWorld as of the last update.
  v1::GetWorldResponse Tell() const;
  /// Of a frame with all columns, as of the last update.
  size_t frame_bytes_max() const { return frame_bytes_max_; }

 private:
  const std::string name_;
  const bool record_state_hash_;
  mutable std::mutex mutex_;
  WorldDesc desc_;
  Stamp stamp_;
  v1::World::State state_ = v1::World::STATE_PAUSED;
  bool is_left_alone_ = false;
  std::atomic<size_t> frame_bytes_max_ = 0;
};

}  // namespace genphys

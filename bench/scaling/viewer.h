#pragma once
#include <cstddef>
#include <cstdint>

#include "genphys/hosting/keyframes.h"
#include "genphys/v1/frame.pb.h"
#include "genphys/world.h"

namespace genphys::bench {

/// Asks after each step for a frame of those who moved, which is encoded as the server does it.
class Viewer {
 public:
  Viewer();

  /// After a step.
  void Look(const World& world);
  /// After a command.
  void Follow(const World& world, const Command& command) { keyframes_.FollowCommands(world, {&command, 1}); }
  /// Bytes of the last frame.
  size_t bytes() const { return bytes_; }

 private:
  v1::FrameRequest request_;
  Keyframes keyframes_;
  uint64_t known_ = 0;  // the keyframe that it has
  size_t bytes_ = 0;
};

}  // namespace genphys::bench

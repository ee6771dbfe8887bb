#pragma once
#include <map>
#include <memory>
#include <mutex>

#include "genphys/hosting/bytes.h"
#include "genphys/state.h"
#include "genphys/v1/frame.pb.h"

namespace genphys {

/// What a world was like after a step, for viewers who were not there and may come back for it when the world has gone
/// on: one copy for all of them, of which a frame is encoded once somebody wants it. Thread-safe.
class KeptState {
 public:
  KeptState(const StateArrays& state, const v1::WorldStamp& stamp) : state_(state), stamp_(stamp) {}

  /// Whether such a frame can be made of a state alone: joints and keyframes are the world's.
  static bool Suffices(const v1::FrameRequest& wanted) { return !wanted.joints() && !wanted.deltas(); }

  /// The whole frame that `wanted` asks for, which is the same for all who give the same request.
  EncodedMessage Encode(const std::shared_ptr<const v1::FrameRequest>& wanted);

 private:
  const StateArrays state_;
  const v1::WorldStamp stamp_;
  std::mutex mutex_;
  std::map<std::shared_ptr<const v1::FrameRequest>, EncodedMessage> frames_;
};

}  // namespace genphys

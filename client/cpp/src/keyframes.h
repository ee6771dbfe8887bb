#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "genphys/status.h"
#include "genphys/v1/frame.pb.h"

namespace genphys::client {

using FramePtr = std::shared_ptr<const v1::Frame>;

/// `received` laid over `keyframe` if it is a delta, else as it is. INTERNAL for a delta against another one.
Result<FramePtr> WholeFrame(FramePtr received, const FramePtr& keyframe);

/// The last keyframe of each kind of frame that steps of a world brought. Thread-safe.
class Keyframes {
 public:
  /// Beyond it all are forgotten: the next frames are whole.
  static constexpr size_t kKindsMax = 16;

  /// The keyframe for frames of `wishes`, whose keyframe_id it sets; null: there is none.
  FramePtr Find(v1::FrameRequest* wishes) const;
  /// Remembers `frame` if it is a keyframe.
  void Keep(const v1::FrameRequest& wishes, const FramePtr& frame);

 private:
  static std::string KeyOf(v1::FrameRequest wishes);

  mutable std::mutex mutex_;
  std::map<std::string, FramePtr> last_;
};

}  // namespace genphys::client

#pragma once
#include <cstddef>
#include <cstdint>
#include <list>
#include <span>
#include <string>
#include <vector>

#include "genphys/command.h"
#include "genphys/hosting/bytes.h"
#include "genphys/hosting/frame_bodies.h"
#include "genphys/hosting/stamp.h"
#include "genphys/v1/frame.pb.h"
#include "genphys/wire/keyframe.h"
#include "genphys/world.h"

namespace genphys {

/// The frames of one world, for viewers and for those who step it, and the whole ones that later ones are told against.
/// As long as nobody wants deltas there are none of these, and the world goes on unobserved. Used by one thread at a
/// time.
class Keyframes {
 public:
  /// Beyond either the one that was not used for longest is forgotten, but never the newest.
  static constexpr size_t kKeyframesMax = 64;
  static constexpr size_t kBytesMax = 64 << 20;
  /// One that was not used for so many changes of the world is forgotten.
  static constexpr uint64_t kUnusedChangesMax = 1000;
  /// A frame of which more than this part differs is whole, and a keyframe itself.
  static constexpr double kDifferingMax = 0.5;

  /// The world took a step, or tried to: who is or was awake may be elsewhere.
  void FollowStep(const World& world);
  /// The world applied `commands`.
  void FollowCommands(const World& world, std::span<const Command> commands);
  /// The world is another one now.
  void Clear() {
    kept_.clear();
    bodies_.Clear();
  }

  struct Encoded {
    EncodedMessage frame;
    uint64_t keyframe_id = 0;  // that it is, or is against; zero: none
  };
  /// The frame of the present that `request` asks for; if that may be a delta, against the keyframe `base` where that
  /// will do.
  Encoded Encode(const World& world, const v1::FrameRequest& request, const v1::WorldStamp& stamp, uint64_t base);

 private:
  struct Kept {
    std::string wishes;  // the request, encoded
    Keyframe keyframe;
    size_t bytes = 0;
    uint64_t made_at = 0;  // number of the change after which it was true
    uint64_t used_at = 0;
    bool check_rows = false;  // entities came or went
  };

  void Changed();
  void Spread(const World& world);
  void Forget();
  Kept* Find(uint64_t id, const std::string& wishes, const World& world, const v1::FrameRequest& request);
  Kept& MakeWhole(const World& world, const v1::FrameRequest& request, const std::string& wishes, uint64_t step);

  FrameBodies bodies_;    // of those that are no keyframes
  std::list<Kept> kept_;  // newest first
  uint64_t changes_ = 0;
  RowSet touched_;  // rows of the present change
};

}  // namespace genphys

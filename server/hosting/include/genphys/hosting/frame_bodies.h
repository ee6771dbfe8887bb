#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "genphys/hosting/bytes.h"
#include "genphys/v1/frame.pb.h"
#include "genphys/world.h"

namespace genphys {

/// The whole frames of one world, but for their stamps. Of a world that rests each is encoded once, and shared by all
/// who ask for the same until something moves. Used by one thread at a time.
class FrameBodies {
 public:
  /// So many are kept of a world at rest, and none that is larger.
  static constexpr size_t kKeptMax = 4;
  static constexpr size_t kBytesMax = 4 << 20;

  Bytes Encode(const World& world, const v1::FrameRequest& request);
  /// The world is another one now.
  void Clear() { changes_.reset(); }

 private:
  struct Kept {
    std::string wishes;  // the request, encoded
    Bytes body;
  };

  std::optional<uint64_t> changes_;  // of the world when it was last asked for
  std::vector<Kept> kept_;           // true as long as that is the same
};

}  // namespace genphys

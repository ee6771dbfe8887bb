#include "genphys/hosting/frame_bodies.h"

#include <algorithm>
#include <utility>

#include "genphys/wire/encode_frame.h"

namespace genphys {
namespace {

Bytes EncodeNow(const World& world, const v1::FrameRequest& request) {
  const FrameEncoder frame(world, request);
  return MakeBytes(frame.size(), [&](char* to) { frame.Write(to); });
}

}  // namespace

Bytes FrameBodies::Encode(const World& world, const v1::FrameRequest& request) {
  if (std::exchange(changes_, world.changes()) != world.changes()) {
    // Most likely it moves on, and keeping this would be for nothing.
    kept_.clear();
    return EncodeNow(world, request);
  }
  std::string wishes = request.SerializeAsString();
  const auto same = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) { return kept.wishes == wishes; });
  if (same != kept_.end()) return same->body;
  Bytes body = EncodeNow(world, request);
  if (kept_.size() < kKeptMax && body.view.size() <= kBytesMax) kept_.push_back({std::move(wishes), body});
  return body;
}

}  // namespace genphys

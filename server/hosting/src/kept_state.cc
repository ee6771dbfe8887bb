#include "kept_state.h"

#include <string>
#include <utility>

#include "genphys/wire/encode_frame.h"

namespace genphys {

EncodedMessage KeptState::Encode(const std::shared_ptr<const v1::FrameRequest>& wanted) {
  const std::lock_guard lock(mutex_);
  EncodedMessage& frame = frames_[wanted];
  if (frame.empty()) {
    const FrameEncoder encoder(state_, *wanted);
    std::string head;
    AppendStamp(stamp_, head);
    frame = {MakeBytes(std::move(head)), MakeBytes(encoder.size(), [&](char* to) { encoder.Write(to); })};
  }
  return frame;
}

}  // namespace genphys

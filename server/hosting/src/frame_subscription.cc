#include "frame_subscription.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "frame_check.h"
#include "genphys/hosting/world_methods.h"
#include "genphys/v1/simulation_service.pb.h"
#include "genphys/wire/wire_format.h"

namespace genphys {
namespace {

v1::FrameRequest PosesOfAll() {
  v1::FrameRequest request;
  request.set_poses(true);
  return request;
}

// WatchFramesResponse{frame}: `frame` is shared by many, the number of skipped frames is each viewer's own and is
// appended to the frame as the last of its fields.
EncodedMessage FrameMessage(const EncodedMessage& frame, uint64_t skipped) {
  std::string tail;
  if (skipped > 0) AppendVarintField(v1::Frame::kSkippedFramesFieldNumber, skipped, tail);
  std::string head;
  AppendFieldHeader(v1::WatchFramesResponse::kFrameFieldNumber, SizeOf(frame) + tail.size(), head);
  EncodedMessage message{MakeBytes(std::move(head))};
  message.insert(message.end(), frame.begin(), frame.end());
  if (!tail.empty()) message.push_back(MakeBytes(std::move(tail)));
  return message;
}

}  // namespace

void FrameSubscription::Open(const Bytes& request) {
  v1::WatchFramesRequest message;
  const Status status = DecodeRequest(request, &message);
  bool waits = false;
  {
    const std::lock_guard lock(hub_->mutex_);
    if (!end_ && hub_->end_) end_ = hub_->end_;
    if (!end_ && !status.ok()) end_ = status;
    if (!end_) {
      if (message.has_every_nth_step()) every_nth_step_ = message.every_nth_step();
      v1::FrameRequest frame = message.has_frame() ? message.frame() : PosesOfAll();
      frame.clear_keyframe_id();
      const std::string key = frame.SerializeAsString();
      auto layout = std::find_if(hub_->layouts_.begin(), hub_->layouts_.end(),
                                 [&](const FrameHub::Layout& other) { return other.key == key; });
      if (layout == hub_->layouts_.end()) {
        layout = hub_->layouts_.insert(layout,
                                       {key, std::make_shared<const v1::FrameRequest>(std::move(frame)), {}, SIZE_MAX});
      }
      wanted_ = layout->request;
      layout->viewers.push_back(weak_from_this());
      open_ = true;
    }
    Settle();
    waits = WaitsForCurrent();
  }
  if (waits) hub_->call_current_();
}

void FrameSubscription::Next(Receiver receiver) {
  std::function<void()> delivery;
  bool waits = false, encodes = false;
  {
    const std::lock_guard lock(hub_->mutex_);
    receiver_ = std::move(receiver);
    encodes = state_ != nullptr;
    if (newest_ || state_) delivery = HandOn();
    Settle();
    waits = WaitsForCurrent();
  }
  // Whoever receives may let go of this.
  const auto hub = hub_;
  if (delivery) encodes ? hub->pool_.Post(std::move(delivery)) : delivery();
  if (waits) hub->call_current_();
}

void FrameSubscription::Cancel() {
  const std::lock_guard lock(hub_->mutex_);
  end_ = absl::CancelledError("the subscriber is gone");
  Settle();
}

void FrameSubscription::CheckOnce(const World& world) {
  if (std::exchange(checked_, true) || end_) return;
  const Status status = CheckFrameEntities(world, *wanted_);
  if (status.ok()) return;
  end_ = status;
  Settle();
}

FrameSubscription::Need FrameSubscription::Offer(uint64_t step, bool is_cheap) {
  if (end_ || step % every_nth_step_ != 0) return Need::kNothing;
  ++frames_due_;
  if (receiver_ || is_cheap) return Need::kFrame;
  if (every_nth_step_ > 1) return KeptState::Suffices(*wanted_) ? Need::kState : Need::kFrame;
  // Whoever wants every step is served with the present when it comes back, and nothing is encoded before.
  wants_current_ = true;
  newest_.reset();
  return Need::kNothing;
}

std::function<void()> FrameSubscription::Take(const Keyframes::Encoded& frame) {
  newest_ = frame;
  state_.reset();
  frames_kept_ = frames_due_;
  wants_current_ = false;
  return receiver_ ? HandOn() : nullptr;
}

std::function<void()> FrameSubscription::Keep(std::shared_ptr<KeptState> state) {
  newest_.reset();
  state_ = std::move(state);
  frames_kept_ = frames_due_;
  wants_current_ = false;
  return receiver_ ? HandOn() : nullptr;
}

std::function<void()> FrameSubscription::HandOn() {
  // The first frame is that of the present, which was not due for anybody.
  const uint64_t skipped = frames_kept_ - std::min(frames_kept_, frames_seen_ + 1);
  frames_seen_ = frames_kept_;
  Receiver receiver = std::exchange(receiver_, nullptr);
  if (state_ != nullptr) {
    return [receiver = std::move(receiver), state = std::exchange(state_, nullptr), wanted = wanted_, skipped] {
      Delivery delivery;
      try {
        delivery.message = FrameMessage(state->Encode(wanted), skipped);
      } catch (const std::exception& exception) {
        delivery.end = absl::InternalError(std::string("the stream failed: ") + exception.what());
      }
      receiver(std::move(delivery));
    };
  }
  keyframe_ = newest_->keyframe_id;
  return [receiver = std::move(receiver), frame = std::exchange(newest_, std::nullopt)->frame, skipped] {
    receiver({FrameMessage(frame, skipped), absl::OkStatus()});
  };
}

void FrameSubscription::Settle() {
  if (!receiver_ || !end_) return;
  hub_->pool_.Post([receiver = std::exchange(receiver_, nullptr), end = *end_] { receiver({std::nullopt, end}); });
}

}  // namespace genphys

#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "genphys/hosting/frame_hub.h"
#include "kept_state.h"

namespace genphys {

/// One viewer. The hub's mutex guards its state.
class FrameSubscription final : public Subscription, public std::enable_shared_from_this<FrameSubscription> {
 public:
  explicit FrameSubscription(std::shared_ptr<FrameHub> hub) : hub_(std::move(hub)) {}

  /// Decodes the request and joins its layout; a bad one ends the stream.
  void Open(const Bytes& request);

  void Next(Receiver receiver) override;
  void Cancel() override;

 private:
  friend class FrameHub;

  // These are called with the hub's mutex held.

  /// Ends the stream if what it asks for never was; whatever goes after the first look leaves its frames.
  void CheckOnce(const World& world);
  /// A frame of `step` came to be: whether this viewer needs it encoded, or the state to make it of when it comes back,
  /// or waits for what is true then. One that is cheap to encode is ready for it.
  enum class Need { kNothing, kFrame, kState };
  Need Offer(uint64_t step, bool is_cheap);
  /// True if this viewer waits for the frame of the present.
  bool WaitsForCurrent() const { return receiver_ && open_ && !end_ && wants_current_; }
  /// Takes the encoded frame: what hands it on if somebody waits, to be run without the lock; else keeps it as the
  /// newest.
  std::function<void()> Take(const Keyframes::Encoded& frame);
  /// The same with what the frame is to be made of, once somebody waits.
  std::function<void()> Keep(std::shared_ptr<KeptState> state);
  std::function<void()> HandOn();
  void Settle();

  const std::shared_ptr<FrameHub> hub_;
  uint64_t every_nth_step_ = 1;
  bool open_ = false;
  bool checked_ = false;
  uint64_t keyframe_ = 0;  // that it was sent last
  Receiver receiver_;      // set: somebody waits
  std::optional<Status> end_;
  bool wants_current_ = true;                       // what it has not seen is what the world is like now
  std::shared_ptr<const v1::FrameRequest> wanted_;  // set once open
  // Kept for a viewer that leaves out steps, for the world may have gone past it: one of these.
  std::optional<Keyframes::Encoded> newest_;
  std::shared_ptr<KeptState> state_;
  uint64_t frames_due_ = 0;   // since it joined
  uint64_t frames_kept_ = 0;  // of those: up to the one that was made last, where another may be under way
  uint64_t frames_seen_ = 0;  // of those: seen or replaced by a newer one
};

}  // namespace genphys

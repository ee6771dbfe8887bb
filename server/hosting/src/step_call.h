#pragma once
#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "genphys/hosting/world_host.h"
#include "genphys/wire/filter.h"
#include "hosted_world.h"

namespace genphys {

/// A Step request under way: its commands, then its steps, in slices.
class StepCall {
 public:
  /// The event that reaches it is the last in a reply, which then says which were left out; WatchEvents has these.
  static constexpr size_t kEventBytesMax = 16 << 20;

  /// What a reply may need to get to the client before its deadline, or a tenth of the time given if that is less.
  static constexpr std::chrono::milliseconds kReplyTimeMax{50};
  using Clock = std::chrono::steady_clock;

  StepCall(HostedWorld& hosted, WorldCall call) : hosted_(hosted), call_(std::move(call)) {}

  /// Goes on until the call is done or `slice_end` is reached, one step at least. The reply, once there is one. What
  /// was done before an error stays done, and the message of the error says how far that is.
  std::optional<Result<EncodedMessage>> Advance(Clock::time_point slice_end);

  /// Whether it changed the world.
  bool has_effect() const { return has_effect_; }
  uint32_t steps_done() const { return steps_done_; }

 private:
  Status Begin();
  Status TakeRequest(Result<std::vector<Command>>& commands);
  Status CheckTime() const;
  // All of its commands are done, or so many.
  Status Failed(const Status& status, std::optional<uint32_t> commands_done = {}) const;
  void Collect(const std::shared_ptr<const EventChunk>& chunk);
  EncodedMessage Finish();
  EncodedMessage WithFrame() const;

  HostedWorld& hosted_;
  WorldCall call_;
  std::shared_ptr<const v1::StepRequest> request_;  // but for its commands and its id
  v1::StepResponse response_;
  bool begun_ = false;
  bool has_effect_ = false;
  uint32_t steps_wanted_ = 0;
  uint32_t steps_done_ = 0;
  Clock::duration reply_time_{0};
  Clock::duration last_step_{0};              // that is done
  std::optional<EventFilter> events_wanted_;  // set: events are asked for
  size_t event_bytes_ = 0;
};

}  // namespace genphys

#pragma once
#include <atomic>
#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "genphys/hosting/stream_reply.h"
#include "genphys/hosting/subscription.h"
#include "genphys/hosting/worker_pool.h"
#include "genphys/hosting/world_host.h"

namespace genphys {

/// A stream of steps: each request is done when the one before it is, and answered in that order. A client that sends
/// faster than its world steps, or does not read, is no longer read itself, so that it holds up nobody but itself and
/// what is kept for it stays within the bounds. Thread-safe; its callbacks never overlap, and none comes after the end.
class Drive final : public Subscription, public std::enable_shared_from_this<Drive> {
 public:
  /// Requests that were taken and whose replies were not sent. The contract says so, too.
  static constexpr size_t kInFlightMax = 16;
  /// While requests wait with so many bytes, no other is taken; while replies do, none is done.
  static constexpr size_t kBytesMax = 16 << 20;

  /// `serve` answers each request. Replies are handed on by `pool`, so that the world's thread need not.
  Drive(std::chrono::steady_clock::time_point deadline, WorkerPool& pool, ServeCall serve)
      : deadline_(deadline), pool_(pool), serve_(std::move(serve)) {}

  /// Takes an encoded DriveRequest. `ready` is called once, when the next may come: on any thread, perhaps before this
  /// returns, and not at all after the end.
  void Take(Bytes request, std::function<void()> ready);
  /// No more requests will come: the stream ends after the last reply.
  void CloseInput();
  /// The stream ends with `why` after what is being done was answered; requests that wait are dropped.
  void End(const Status& why);

  void Next(Receiver receiver) override;
  void Cancel() override;

 private:
  using Action = std::function<void()>;

  // These are called with the mutex held.
  void Pump(std::unique_lock<std::mutex>& lock);
  Action NextAction();
  Action SendReply();
  Action DoRequest();
  Action Finish(Status end);
  std::optional<Status> EndNow() const;
  bool CanDoRequest() const;

  void Answer(const Result<EncodedMessage>& outcome);

  const std::chrono::steady_clock::time_point deadline_;
  WorkerPool& pool_;
  const ServeCall serve_;
  std::atomic<bool> cancelled_ = false;
  std::mutex mutex_;
  bool pumping_ = false;  // a thread is at it, and sees what others change
  std::deque<Bytes> requests_;
  size_t request_bytes_ = 0;
  bool at_world_ = false;
  std::deque<EncodedMessage> replies_;
  size_t reply_bytes_ = 0;
  bool sending_ = false;         // a reply was handed on, and nobody asked for the next
  std::function<void()> ready_;  // set: the client waits to be read
  Receiver receiver_;            // set: somebody waits
  bool input_closed_ = false;
  std::optional<Status> end_;
  bool ended_ = false;
};

}  // namespace genphys

#pragma once
#include <atomic>
#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "genphys/hosting/stream_reply.h"
#include "genphys/hosting/subscription.h"
#include "genphys/hosting/worker_pool.h"
#include "genphys/hosting/world_host.h"

namespace genphys {

/// A call of StepWorlds under way: its requests go to their worlds, its replies to whoever asks for the next message.
/// It holds little, however many worlds there are and however slowly the client reads: see the bounds. Thread-safe.
class StepWorldsCall final : public Subscription, public std::enable_shared_from_this<StepWorldsCall> {
 public:
  /// So many requests, or twice as many as the pool has threads, go to their worlds at once; the others wait until one
  /// is answered or was there for kLong, so that nobody waits for slow worlds. While nobody waits for the next message,
  /// replies that were not sent count among them: who does not read need not be ahead.
  static constexpr size_t kWithWorldsMax = 16;
  static constexpr std::chrono::milliseconds kLong{10};
  /// No request goes to its world that would bring replies that were not sent beyond so many bytes, those that are to
  /// come included: as large as is expected, and larger by as much as one was so far. As many as the pool has threads
  /// go all the same while they are read.
  static constexpr size_t kUnsentBytesMax = 16 << 20;
  /// A message ends with the reply that reaches this size, so that it stays below what gRPC clients accept by default.
  static constexpr size_t kMessageBytesMax = 1 << 20;
  /// Between two messages, unless so many replies wait or none is to come: each message wakes the client, who on the
  /// same machine takes a processor from the worlds. 64 worlds of 50 bodies on two of them went 1.4 times as fast as in
  /// one thread on Bullet when replies went out one by one.
  static constexpr std::chrono::milliseconds kPause{5};
  static constexpr size_t kGathered = 32;
  /// Worlds end by so much before the deadline, or a tenth of the time given if that is less: who meets it hears
  /// nothing of them any more.
  static constexpr std::chrono::milliseconds kReplyTimeMax{50};

  /// How many bytes the reply to an encoded StepRequest will have, as far as that can be told.
  using Expect = std::function<size_t(const Bytes& request)>;

  /// `requests` are encoded StepRequests, `serve` answers each. `pool`, which outlives the call, keeps time.
  StepWorldsCall(std::vector<Bytes> requests, std::chrono::steady_clock::time_point deadline, WorkerPool& pool,
                 ServeCall serve, Expect expect);

  /// Sends the first requests to their worlds.
  void Begin() { BeginMore(); }

  void Next(Receiver receiver) override;
  void Cancel() override;

 private:
  void BeginMore();
  void Finish(size_t index, const Result<EncodedMessage>& outcome);
  void Deliver(std::unique_lock<std::mutex>& lock);
  bool MayBegin();
  bool HasRoomFor(size_t bytes) const;
  bool IsTheirTurn();
  bool IsDone() const { return begun_ == requests_.size() && with_worlds_.empty(); }
  bool IsTimeToSend();
  EncodedMessage TakeMessage();

  struct WithWorld {
    WorkerPool::Clock::time_point since;
    size_t expected_bytes = 0;
  };

  std::vector<Bytes> requests_;
  const std::chrono::steady_clock::time_point deadline_;  // of worlds
  WorkerPool& pool_;
  const ServeCall serve_;
  const Expect expect_;
  std::atomic<bool> cancelled_ = false;
  std::mutex mutex_;
  bool beginning_ = false;  // a thread is at it
  size_t begun_ = 0;
  std::optional<size_t> next_bytes_;         // expected of the next one to begin
  std::map<size_t, WithWorld> with_worlds_;  // by index, and so by when they went there
  size_t expected_bytes_ = 0;                // of them
  std::deque<EncodedMessage> unsent_;
  size_t unsent_bytes_ = 0;
  size_t unexpected_bytes_ = 0;  // by which a reply was larger than expected, at most
  WorkerPool::Clock::time_point last_sent_ = WorkerPool::Clock::now();
  bool is_timed_ = false;       // the pool will look again
  bool is_turn_timed_ = false;  // it will see whether others may begin
  Receiver receiver_;           // set: somebody waits
};

}  // namespace genphys

#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "genphys/event.h"
#include "genphys/hosting/stamp.h"
#include "genphys/hosting/subscription.h"
#include "genphys/hosting/worker_pool.h"
#include "genphys/wire/filter.h"

namespace genphys {

/// What was recorded at one step boundary. Immutable, and encoded at most once however many read it.
class EventChunk {
 public:
  /// `events` is not empty and dense in sequence. The epoch of `stamp` is left to the log.
  EventChunk(const Stamp& stamp, std::vector<Event> events);

  const Stamp& stamp() const { return stamp_; }
  std::span<const Event> events() const { return events_; }
  uint64_t first_sequence() const { return events_.front().sequence; }
  uint64_t last_sequence() const { return events_.back().sequence; }
  /// Roughly what it occupies in memory.
  size_t bytes() const { return bytes_; }

  /// The events from the `begin`th up to, not including, the `end`th as fields of an EventBatch. Thread-safe.
  std::string_view Encoded(size_t begin, size_t end, bool contact_points) const;

 private:
  struct Encoding {
    std::once_flag once;
    std::string bytes;
    std::vector<size_t> offsets;
  };

  Stamp stamp_;
  std::vector<Event> events_;
  size_t bytes_ = 0;
  mutable Encoding encodings_[2];
};

/// Who touches whom, and who is inside whose sensor, as events tell it.
class TouchingNow {
 public:
  void Follow(const Event& event);
  /// One ContactPersisted or SensorEntered without a number for each pair, in order of ids.
  std::vector<Event> Pairs(uint64_t step) const;

 private:
  std::set<EntityPair> contacts_;
  std::set<std::pair<EntityId, EntityId>> visits_;  // sensor, visitor
};

class EventSubscription;

/// The newest events of one world, numbered densely within an epoch, and those who wait for more. What is beyond the
/// bounds is forgotten, oldest chunk first; a subscriber that was not there yet is told the exact range it lost and the
/// pairs that touched then, and goes on. Subscribers never hold up the world. Thread-safe.
class EventLog : public std::enable_shared_from_this<EventLog> {
 public:
  static constexpr size_t kEventsMax = 65536;
  static constexpr size_t kBytesMax = 32 << 20;
  /// A batch ends with the event that reaches this size, so that it stays below what gRPC clients accept by default.
  static constexpr size_t kBatchBytesMax = 1 << 20;
  /// A subscriber whose filter let nothing through learns how far it is at least this often, while events come.
  static constexpr std::chrono::seconds kBookmarkPeriod{1};

  struct Bounds {
    size_t events = kEventsMax;
    size_t bytes = kBytesMax;
  };

  EventLog(WorkerPool& pool, const Stamp& now) : EventLog(pool, now, Bounds{}) {}
  EventLog(WorkerPool& pool, const Stamp& now, Bounds bounds);

  /// What happened up to `now`; null: nothing did.
  void Append(const Stamp& now, std::shared_ptr<const EventChunk> chunk);
  /// Remembers the present as what Restart() comes back to.
  void MarkBeginning();
  /// Without a mark it comes back to the present that it finds then.
  void ForgetBeginning();
  /// A new epoch begins at the mark: what came before the mark happens again, under the same numbers.
  void Restart(const Stamp& now);
  /// Ends all present and future streams with `why`, after what is there was delivered.
  void End(const Status& why);

  /// Number of the newest event of this epoch; zero: there is none.
  uint64_t last_sequence() const;

  /// Subscribes by an encoded WatchEventsRequest, which is read on a worker.
  std::shared_ptr<Subscription> Watch(Bytes request);

 private:
  friend class EventSubscription;

  struct Chunks {
    std::deque<std::shared_ptr<const EventChunk>> kept;
    size_t events = 0;
    size_t bytes = 0;
    // As of the event before the first that is kept.
    TouchingNow touching_before;
    Stamp stamp_before;
    uint64_t first_sequence = 1;
    uint64_t last_sequence = 0;
  };
  struct PastEpoch {
    Stamp last_stamp;
    uint64_t last_sequence = 0;
  };

  void Forget();
  void WakeSubscribers();

  WorkerPool& pool_;
  const Bounds bounds_;
  mutable std::mutex mutex_;
  Stamp now_;
  Chunks chunks_;
  std::optional<Chunks> beginning_;
  PastEpoch past_;
  std::optional<Status> end_;
  std::list<std::weak_ptr<EventSubscription>> subscribers_;
};

}  // namespace genphys

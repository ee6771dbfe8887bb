#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "genphys/client/frame.h"
#include "genphys/client/options.h"
#include "genphys/event.h"
#include "genphys/status.h"

namespace genphys::client {

/// Numbers of events that were lost: the listener was too slow, or came back too late, or a reply had no room for them.
struct Gap {
  uint64_t first_sequence = 0;
  uint64_t last_sequence = 0;
};

/// Everything from first_sequence to last_sequence was delivered here or left out by the filter.
struct EventBatch {
  Stamp stamp;                // of the last event; another epoch than before: time went back and numbers begin anew
  std::vector<Event> events;  // empty: only tells how far the world has come
  uint64_t first_sequence = 0;
  uint64_t last_sequence = 0;
  std::optional<Gap> gap;
};

/// Events as they happen. One thread calls Next(), any thread Cancel(). A lost connection is taken up again where it
/// broke, for half a minute; what was lost meanwhile is told as a gap.
class EventStream {
 public:
  EventStream(EventStream&&) noexcept;
  EventStream& operator=(EventStream&&) noexcept;
  /// Ends the subscription.
  ~EventStream();

  /// Waits for the next batch: nothing when the stream has ended, because it was cancelled or the world deleted.
  /// DEADLINE_EXCEEDED after `timeout`: the stream lives on. Unset: waits as long as it takes.
  Result<std::optional<EventBatch>> Next(std::optional<std::chrono::milliseconds> timeout = std::nullopt);

  /// A Next() that waits returns nothing, and so do all later ones.
  void Cancel();

  /// Of the last event that Next() has looked at; before the first, of the moment of subscribing.
  StreamPosition position() const;

 private:
  friend class World;
  class Impl;
  explicit EventStream(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Frames as they happen: Next() has the newest, and how many were missed. A slow viewer never delays them, but all are
/// sent and read: of a world that plays faster than anybody looks, ask for every nth step. Used like an EventStream.
class FrameStream {
 public:
  FrameStream(FrameStream&&) noexcept;
  FrameStream& operator=(FrameStream&&) noexcept;
  ~FrameStream();

  /// The first frame comes at once: the state as it is.
  Result<std::optional<Frame>> Next(std::optional<std::chrono::milliseconds> timeout = std::nullopt);
  void Cancel();

 private:
  friend class World;
  class Impl;
  explicit FrameStream(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace genphys::client

#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "genphys/hosting/bytes.h"
#include "genphys/hosting/subscription.h"
#include "genphys/status.h"

namespace genphys {

/// The requests that one world answers. CreateWorld and ListWorlds are the directory's.
enum class WorldMethod : uint8_t {
  kGetWorld,
  kDeleteWorld,
  kResetWorld,
  kPlayWorld,
  kPauseWorld,
  kCreateEntity,
  kDeleteEntity,
  kApplyForce,
  kGetEntity,
  kListEntities,
  kListJoints,
  kListForceFields,
  kStep,
  kCastRays,
  kCastShape,
  kFindOverlaps,
  kFindClosest,
  kMeasureDistances,
  kGetContacts,
  kWatchEvents,
  kWatchFrames,
};

/// So long may who waits for a step keep the thread that brought it: to wake another one costs a step of half a
/// millisecond a twentieth more, and others whose calls come to that thread wait no longer than this.
inline constexpr std::chrono::microseconds kQuickStep{2000};

/// One request on its way to a world.
struct WorldCall {
  WorldMethod method{};
  Bytes request;           // encoded
  std::string request_id;  // as in the request; empty: none
  bool has_commands = false;
  /// Work stops soon after it: see WorkWatch.
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  /// Whether nobody waits any more; work stops soon then. Asked until the reply is made. Empty: somebody always does.
  std::function<bool()> is_cancelled;
  /// Where the last step took less, this one is done on the thread that brings it: waking another one takes tens of
  /// microseconds. Zero: it has others to bring.
  std::chrono::microseconds here_below = kQuickStep;

  /// Set once the time of all calls is over, for the server stops. Null: it goes on.
  std::shared_ptr<const std::atomic<bool>> is_over;

  /// CANCELLED, DRAINING, DEADLINE_EXCEEDED, or OK while somebody waits for the reply.
  Status CheckWanted() const;
};

/// Called once with the encoded reply or why there is none, on any thread.
using Reply = std::function<void(Result<EncodedMessage>)>;

/// One world as the front sees it, wherever it lives: encoded requests in, encoded replies and streams out. Decoding,
/// validation and encoding happen on the world's side. Thread-safe; no call takes long.
class WorldHost {
 public:
  virtual ~WorldHost() = default;

  /// Answers `call`. Calls take effect in the order in which they are made, except kGetWorld, which waits for
  /// nothing and tells how the world was after its last step. kDeleteWorld ends the world and its streams; calls that
  /// are not answered yet are refused.
  virtual void Handle(WorldCall call, Reply reply) = 0;

  /// How large a frame of it may be at most, as it was after its last step. Waits for nothing.
  virtual size_t frame_bytes_max() const = 0;

  /// Subscribes by an encoded WatchEventsRequest or WatchFramesRequest; a bad one ends the stream with the refusal.
  virtual std::shared_ptr<Subscription> Watch(WorldMethod method, Bytes request) = 0;

  /// Ends every stream with `why` and stops the world from moving by itself.
  virtual void Drain(Status why) = 0;
};

}  // namespace genphys

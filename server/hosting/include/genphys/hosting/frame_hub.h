#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "genphys/hosting/keyframes.h"
#include "genphys/hosting/stamp.h"
#include "genphys/hosting/subscription.h"
#include "genphys/hosting/worker_pool.h"
#include "genphys/v1/frame.pb.h"
#include "genphys/world.h"

namespace genphys {

class FrameSubscription;

/// The viewers of one world. Newest wins: a viewer that is not done with a frame misses those that come meanwhile, and
/// is told how many. A frame is encoded once for all who ask for the same columns and, of deltas, have the same
/// keyframe, and a large one not at all while nobody waits for it; but for deltas and joints of steps that the world
/// may have gone past when somebody does. Viewers never hold up the world. Thread-safe, but Publish() and
/// PublishCurrent() are the world's alone.
class FrameHub : public std::enable_shared_from_this<FrameHub> {
 public:
  /// A frame of up to so many bytes is encoded before somebody waits for it, and for one viewer alone it is sent by the
  /// world's own thread: both take less time than waking another.
  static constexpr size_t kWrittenHereMax = 4096;

  /// `call_current` is called, on any thread and with no lock held, when a viewer waits for the frame of the present:
  /// the world then calls PublishCurrent() soon.
  FrameHub(WorkerPool& pool, std::function<void()> call_current);

  /// Whether Publish() at `step` would have anything to do; cheap.
  bool HasViewers() const;
  /// `world` changed: it is at the step of `stamp` now.
  void Publish(const World& world, const Stamp& stamp, Keyframes& keyframes);
  /// Serves those who wait for the frame of the present.
  void PublishCurrent(const World& world, const Stamp& stamp, Keyframes& keyframes);
  /// Ends all present and future streams with `why`.
  void End(const Status& why);

  /// Subscribes by an encoded WatchFramesRequest, which is read on a worker.
  std::shared_ptr<Subscription> Watch(Bytes request);

 private:
  friend class FrameSubscription;

  // Viewers that want the same columns.
  struct Layout {
    std::string key;  // the encoded request
    std::shared_ptr<const v1::FrameRequest> request;
    std::vector<std::weak_ptr<FrameSubscription>> viewers;
    size_t frame_bytes = SIZE_MAX;  // of the last one
  };

  // Who is to be given what, as is known with the lock held.
  struct Orders;
  Orders TakeOrders(const World& world, const Stamp& stamp, bool is_new);
  void Send(std::vector<std::function<void()>> deliveries, size_t bytes);
  void Deliver(const World& world, const Stamp& stamp, Keyframes& keyframes, bool is_new);

  WorkerPool& pool_;
  const std::function<void()> call_current_;
  mutable std::mutex mutex_;
  std::list<Layout> layouts_;
  std::optional<Status> end_;
};

}  // namespace genphys

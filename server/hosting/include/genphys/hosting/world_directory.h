#pragma once
#include <atomic>
#include <chrono>
#include <compare>
#include <cstddef>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "genphys/hosting/drive.h"
#include "genphys/hosting/memory_return.h"
#include "genphys/hosting/reply_cache.h"
#include "genphys/hosting/worker_pool.h"
#include "genphys/hosting/world_host.h"
#include "genphys/v1/world_service.pb.h"

namespace genphys {

/// What tells worlds apart. Owners do not see each other's worlds; the empty one owns all as long as nobody signs in.
struct WorldKey {
  std::string owner;
  std::string name;  // as in "worlds/w"
  auto operator<=>(const WorldKey&) const = default;
};

/// All worlds of a server: finds the one that a request is for, makes, lists and ends them. Thread-safe; no call blocks
/// or does physics.
class WorldDirectory {
 public:
  static constexpr size_t kWorldsMax = 1024;

  /// Makes the world `wanted` under `name`; called on a worker.
  using HostFactory =
      std::function<Result<std::shared_ptr<WorldHost>>(const std::string& name, const v1::World& wanted)>;

  /// `pool` outlives the directory. Beyond `worlds_max` worlds CreateWorld is refused with LIMIT_EXCEEDED.
  WorldDirectory(WorkerPool& pool, HostFactory make_host, size_t worlds_max = kWorldsMax);

  /// Answers an encoded CreateWorldRequest. A repeated request id gets the first reply, however many are under way.
  void Create(Bytes request, Reply reply);
  /// Answers an encoded ListWorldsRequest.
  void List(const Bytes& request, const Reply& reply);
  /// Answers a request to one world, whose name and request id it reads. WORLD_NOT_FOUND if there is none; a request
  /// that is wrong otherwise is refused for that.
  void Handle(WorldCall call, Reply reply);
  /// Subscribes at a world. A stream that cannot be ends at once with the reason.
  std::shared_ptr<Subscription> Watch(WorldMethod method, Bytes request);
  /// The replies to an encoded StepWorldsRequest. One that is wrong as a whole ends at once with the reason.
  std::shared_ptr<Subscription> StepWorlds(const Bytes& request, std::chrono::steady_clock::time_point deadline);
  /// A stream of steps, of whichever worlds they name.
  std::shared_ptr<Drive> OpenDrive(std::chrono::steady_clock::time_point deadline);

  /// From now on everything is refused with DRAINING, streams end with it, and no world moves by itself. Calls under
  /// way go on.
  void Drain();
  /// Calls under way end, too, as they do at a deadline: soon, and saying how far they came.
  void EndCalls() { *is_over_ = true; }

 private:
  struct Creation;
  struct Page;

  std::shared_ptr<WorldHost> Find(const WorldKey& key) const;
  void MakeWorld(const std::shared_ptr<Creation>& creation);
  bool Repeats(const std::shared_ptr<Creation>& creation);
  Status Reserve(Creation& creation);
  void Unreserve(const WorldKey& key);
  void FinishCreation(const std::shared_ptr<Creation>& creation, const Result<EncodedMessage>& outcome);
  Status Unknown(const WorldCall& call) const;
  size_t StepReplyBytes(const Bytes& request) const;
  void ListPage(const Bytes& request, const Reply& reply);

  WorkerPool& pool_;
  const HostFactory make_host_;
  const size_t worlds_max_;
  std::atomic<bool> draining_ = false;
  const std::shared_ptr<std::atomic<bool>> is_over_ = std::make_shared<std::atomic<bool>>(false);
  mutable std::mutex mutex_;
  std::map<WorldKey, std::shared_ptr<WorldHost>> worlds_;  // null: being made
  ReplyCache created_;
  std::unordered_map<std::string, std::shared_ptr<Creation>> being_created_;  // by request id
  std::list<std::weak_ptr<Drive>> drives_;
  MemoryReturn memory_return_;
};

}  // namespace genphys

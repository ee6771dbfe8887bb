#pragma once
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "genphys/hosting/reply_cache.h"
#include "genphys/hosting/strand.h"
#include "genphys/hosting/worker_pool.h"
#include "genphys/hosting/world_host.h"
#include "genphys/registry.h"
#include "genphys/v1/world_service.pb.h"

namespace genphys {

class HostedWorld;

/// A world in this process, on a strand of the pool. A Step of many steps yields to other worlds after every slice, and
/// a playing world gives every request its turn between its own steps.
class InProcessHost final : public WorldHost, public std::enable_shared_from_this<InProcessHost> {
 public:
  /// Requests that may wait for one world, and their bytes; beyond either LIMIT_EXCEEDED.
  static constexpr size_t kMailboxCallsMax = 256;
  static constexpr size_t kMailboxBytesMax = 256 << 20;

  /// The world called `name` that `wanted` asks for. `registry` and `pool` outlive it.
  static Result<std::shared_ptr<WorldHost>> Create(const BackendRegistry& registry, WorkerPool& pool,
                                                   const std::string& name, const v1::World& wanted,
                                                   std::string_view default_engine);
  ~InProcessHost() override;

  void Handle(WorldCall call, Reply reply) override;
  size_t frame_bytes_max() const override;
  std::shared_ptr<Subscription> Watch(WorldMethod method, Bytes request) override;
  void Drain(Status why) override;

 private:
  explicit InProcessHost(WorkerPool& pool);

  struct Pending;

  void Tell(const WorldCall& call, const Reply& reply) const;
  void Finish(Pending& pending, const Result<EncodedMessage>& outcome);

  // On the strand.
  Progress Serve(Pending& pending);
  Progress ServeShort(Pending& pending);
  Progress ServeStep(Pending& pending);
  std::optional<Result<EncodedMessage>> FindReply(Pending& pending);
  void FinishAndKeep(Pending& pending, const Result<EncodedMessage>& outcome, bool keep);
  Status Broken(const Status& why);
  void PostPlay(uint64_t generation);
  void Play(uint64_t generation);
  void PublishCurrent();
  void Close(const Reply& reply);

  WorkerPool& pool_;
  const std::shared_ptr<Strand> strand_;
  std::unique_ptr<HostedWorld> hosted_;  // set once, before the host is shared
  std::atomic<size_t> waiting_calls_ = 0;
  std::atomic<size_t> waiting_bytes_ = 0;
  std::atomic<bool> closing_ = false;
  std::atomic<bool> draining_ = false;
  std::atomic<std::chrono::nanoseconds> last_step_ = std::chrono::nanoseconds::max();  // how long it took
  // On the strand.
  ReplyCache replies_;
  uint64_t play_generation_ = 0;
};

}  // namespace genphys

#pragma once
#include <atomic>
#include <chrono>
#include <memory>

#include "genphys/hosting/worker_pool.h"

namespace genphys {

/// Gives memory that is free back to the system a while after worlds ended: the allocator keeps it by itself, and a
/// server that once held many worlds would hold their memory for ever. Thread-safe.
class MemoryReturn {
 public:
  /// `pool` outlives this object.
  explicit MemoryReturn(WorkerPool& pool) : pool_(pool) {}

  /// A world ended, or is about to: of many within kPause, one return serves all.
  void Note();

 private:
  // What is given back has to be faulted in again: who makes and ends worlds all the time shall not feel that.
  static constexpr WorkerPool::Clock::duration kPause = std::chrono::seconds(5);

  WorkerPool& pool_;
  // Tasks may outlive this object.
  const std::shared_ptr<std::atomic<bool>> is_due_ = std::make_shared<std::atomic<bool>>(false);
};

}  // namespace genphys

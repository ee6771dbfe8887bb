#pragma once
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>

#include "genphys/hosting/worker_pool.h"

namespace genphys {

/// How long one strand keeps a worker before others that wait get their turn, unless a single piece of work takes
/// longer.
inline constexpr std::chrono::milliseconds kSlice{1};

enum class Progress {
  kDone,   // the work is finished
  kAgain,  // call it again after others that wait had their turn
};

/// Work that never overlaps, on the threads of a pool: one world's worth of it. Work is done in the order of posting;
/// work that is not done after a slice keeps its place while other strands have their turn. Thread-safe.
class Strand : public std::enable_shared_from_this<Strand> {
 public:
  using Work = std::function<Progress()>;

  explicit Strand(WorkerPool& pool) : pool_(pool) {}

  /// Does `work` after all that was posted before. Its poster bounds how much that can be.
  void Post(Work work);
  /// The same, but if nothing is posted or under way, does it here and now, at most once: what is left then, of it and
  /// of what came meanwhile, is posted. For work that takes less time than it takes to wake another thread.
  void RunOrPost(Work work);
  /// Does `task` before all other work, if need be between two slices of work that is not done.
  void PostUrgent(std::function<void()> task);

 private:
  enum class On { kWorker, kPoster };

  void Schedule(std::unique_lock<std::mutex>& lock);
  void TakeTurn(On thread);
  void RunUrgent(std::unique_lock<std::mutex>& lock);

  WorkerPool& pool_;
  std::mutex mutex_;
  std::deque<Work> work_;
  std::deque<std::function<void()>> urgent_;
  bool scheduled_ = false;
};

}  // namespace genphys

#pragma once
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

namespace genphys {

/// A fixed number of threads that run tasks in the order of their posting, and a clock that posts tasks when they are
/// due. Nothing polls: without tasks every thread sleeps. Thread-safe.
class WorkerPool {
 public:
  using Clock = std::chrono::steady_clock;
  using Task = std::function<void()>;

  /// `threads` workers; zero: one per processor.
  explicit WorkerPool(unsigned threads = 0);
  /// Runs what is queued, drops what is not due yet, and joins.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Runs `task` on some worker. The queue has no bound of its own: every poster has one task in it at a time, or
  /// bounds what it posts. An exception that leaves a task is logged and goes no further.
  void Post(Task task);
  /// Posts `task` once `when` is reached.
  void PostAt(Clock::time_point when, Task task);

  /// Whether more tasks wait than workers that have nothing to do.
  bool IsShort() const;

  unsigned threads() const { return static_cast<unsigned>(workers_.size()); }

 private:
  void Work();
  void KeepTime();

  mutable std::mutex mutex_;
  std::condition_variable work_came_;
  std::condition_variable timer_came_;
  std::deque<Task> tasks_;
  std::multimap<Clock::time_point, Task> timers_;
  size_t idle_ = 0;  // workers that have been woken and have not come yet are among them
  bool stopping_ = false;
  std::vector<std::thread> workers_;
  std::thread timekeeper_;
};

}  // namespace genphys

#pragma once
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <thread>

namespace genphys {

/// A fixed number of threads that run tasks in the order of their posting, and a clock that posts tasks when they are
/// due. Nothing polls: without tasks every thread sleeps. While a task holds a worker for long, as a world does whose
/// one step takes seconds, and others wait, a spare one takes its place until it comes back. Thread-safe.
class WorkerPool {
 public:
  /// A worker that is in one task for longer than this is held: the processor is shared with it by the system then.
  static constexpr std::chrono::milliseconds kHeld{100};
  /// No more spare workers than these: whoever holds all of them holds what is posted later, too.
  static constexpr size_t kSparesMax = 64;

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

  /// Without spare ones.
  unsigned threads() const { return static_cast<unsigned>(usual_); }

 private:
  struct Worker {
    std::thread thread;
    Clock::time_point since = Clock::time_point::max();  // the beginning of its task
    bool is_gone = false;
  };

  void Start();
  void Work(Worker& self);
  void KeepTime();
  void LookAfterTheHeld();
  bool BeginToLook();
  bool IsSpare() const;
  size_t CountFree(Clock::time_point now) const;

  mutable std::mutex mutex_;
  std::condition_variable work_came_;
  std::condition_variable timer_came_;
  std::deque<Task> tasks_;
  std::multimap<Clock::time_point, Task> timers_;
  size_t idle_ = 0;  // workers that have been woken and have not come yet are among them
  bool stopping_ = false;
  size_t usual_ = 0;
  std::list<Worker> workers_;
  // When somebody looks whether all are held, while tasks wait.
  Clock::time_point look_at_ = Clock::time_point::max();
  uint64_t taken_ = 0;         // tasks, by all workers
  uint64_t taken_before_ = 0;  // when it was decided to look
  std::thread timekeeper_;
};

}  // namespace genphys

#include "genphys/hosting/worker_pool.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <utility>

namespace genphys {
namespace {

void Run(const WorkerPool::Task& task) {
  try {
    task();
  } catch (const std::exception& exception) {
    spdlog::critical("a task failed: {}", exception.what());
  } catch (...) {
    spdlog::critical("a task failed with an exception of an unknown type");
  }
}

}  // namespace

WorkerPool::WorkerPool(unsigned threads) {
  const unsigned count = threads != 0 ? threads : std::max(1u, std::thread::hardware_concurrency());
  for (unsigned i = 0; i < count; ++i) workers_.emplace_back([this] { Work(); });
  timekeeper_ = std::thread([this] { KeepTime(); });
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  work_came_.notify_all();
  timer_came_.notify_all();
  timekeeper_.join();
  for (std::thread& worker : workers_) worker.join();
}

void WorkerPool::Post(Task task) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
  }
  work_came_.notify_one();
}

void WorkerPool::PostAt(Clock::time_point when, Task task) {
  bool is_first;
  {
    const std::lock_guard lock(mutex_);
    const auto timer = timers_.emplace(when, std::move(task));
    is_first = timer == timers_.begin();
  }
  if (is_first) timer_came_.notify_one();
}

bool WorkerPool::IsShort() const {
  const std::lock_guard lock(mutex_);
  return tasks_.size() > idle_;
}

void WorkerPool::Work() {
  std::unique_lock lock(mutex_);
  while (true) {
    ++idle_;
    work_came_.wait(lock, [this] { return stopping_ || !tasks_.empty(); });
    --idle_;
    if (tasks_.empty()) return;
    {
      // Gone before the lock is taken again, for what a task holds may post when it is destroyed.
      const Task task = std::move(tasks_.front());
      tasks_.pop_front();
      lock.unlock();
      Run(task);
    }
    lock.lock();
  }
}

void WorkerPool::KeepTime() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (timers_.empty()) {
      timer_came_.wait(lock);
    } else if (const auto first = timers_.begin(); first->first <= Clock::now()) {
      tasks_.push_back(std::move(first->second));
      timers_.erase(first);
      work_came_.notify_one();
    } else {
      const Clock::time_point when = first->first;
      timer_came_.wait_until(lock, when);
    }
  }
}

}  // namespace genphys

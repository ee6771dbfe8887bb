#include "genphys/hosting/worker_pool.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <system_error>
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
  usual_ = threads != 0 ? threads : std::max(1u, std::thread::hardware_concurrency());
  const std::lock_guard lock(mutex_);
  for (size_t i = 0; i < usual_; ++i) Start();
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
  for (Worker& worker : workers_) worker.thread.join();
}

void WorkerPool::Start() {
  Worker& worker = workers_.emplace_back();
  worker.thread = std::thread([this, &worker] { Work(worker); });
}

void WorkerPool::Post(Task task) {
  bool begins_to_look;
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
    begins_to_look = BeginToLook();
  }
  work_came_.notify_one();
  if (begins_to_look) timer_came_.notify_one();
}

// Whether the timekeeper has to know of it.
bool WorkerPool::BeginToLook() {
  if (tasks_.size() <= idle_ || look_at_ != Clock::time_point::max()) return false;
  look_at_ = Clock::now() + kHeld;
  taken_before_ = taken_;
  return true;
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

void WorkerPool::Work(Worker& self) {
  std::unique_lock lock(mutex_);
  while (!IsSpare()) {
    ++idle_;
    work_came_.wait(lock, [this] { return stopping_ || !tasks_.empty(); });
    --idle_;
    if (tasks_.empty()) return;
    ++taken_;
    self.since = Clock::now();
    {
      // Gone before the lock is taken again, for what a task holds may post when it is destroyed.
      const Task task = std::move(tasks_.front());
      tasks_.pop_front();
      lock.unlock();
      Run(task);
    }
    lock.lock();
    self.since = Clock::time_point::max();
  }
  self.is_gone = true;
}

// Of whom is in no task, or has not been in one for long.
size_t WorkerPool::CountFree(Clock::time_point now) const {
  return static_cast<size_t>(std::ranges::count_if(workers_, [&](const Worker& worker) {
    return !worker.is_gone && (worker.since > now || now - worker.since < kHeld);
  }));
}

// Whether one more is free than there should be: somebody came back who was held.
bool WorkerPool::IsSpare() const { return !stopping_ && workers_.size() > usual_ && CountFree(Clock::now()) > usual_; }

// While tasks wait and nobody has taken one for so long, all are held.
void WorkerPool::LookAfterTheHeld() {
  std::erase_if(workers_, [](Worker& worker) {
    if (worker.is_gone) worker.thread.join();
    return worker.is_gone;
  });
  look_at_ = Clock::time_point::max();
  if (tasks_.empty()) return;
  if (taken_ == taken_before_ && workers_.size() < usual_ + kSparesMax) {
    try {
      Start();
    } catch (const std::system_error& error) {
      workers_.pop_back();
      spdlog::error("there is no thread to take the place of one that is held: {}", error.what());
    }
  }
  look_at_ = Clock::now() + kHeld;
  taken_before_ = taken_;
}

void WorkerPool::KeepTime() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const auto now = Clock::now();
    const auto first = timers_.begin();
    if (look_at_ <= now) {
      LookAfterTheHeld();
    } else if (first != timers_.end() && first->first <= now) {
      tasks_.push_back(std::move(first->second));
      timers_.erase(first);
      BeginToLook();
      work_came_.notify_one();
    } else if (const auto when = first == timers_.end() ? look_at_ : std::min(look_at_, first->first);
               when == Clock::time_point::max()) {
      timer_came_.wait(lock);
    } else {
      timer_came_.wait_until(lock, when);
    }
  }
}

}  // namespace genphys

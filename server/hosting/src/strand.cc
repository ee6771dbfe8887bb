#include "genphys/hosting/strand.h"

#include <utility>

namespace genphys {

void Strand::Post(Work work) {
  std::unique_lock lock(mutex_);
  work_.push_back(std::move(work));
  Schedule(lock);
}

void Strand::RunOrPost(Work work) {
  std::unique_lock lock(mutex_);
  work_.push_back(std::move(work));
  if (scheduled_) return;
  scheduled_ = true;
  lock.unlock();
  TakeTurn(On::kPoster);
}

void Strand::PostUrgent(std::function<void()> task) {
  std::unique_lock lock(mutex_);
  urgent_.push_back(std::move(task));
  Schedule(lock);
}

void Strand::Schedule(std::unique_lock<std::mutex>& lock) {
  if (std::exchange(scheduled_, true)) return;
  lock.unlock();
  pool_.Post([self = shared_from_this()] { self->TakeTurn(On::kWorker); });
}

void Strand::RunUrgent(std::unique_lock<std::mutex>& lock) {
  while (!urgent_.empty()) {
    const std::function<void()> task = std::move(urgent_.front());
    urgent_.pop_front();
    lock.unlock();
    task();
    lock.lock();
  }
}

void Strand::TakeTurn(On thread) {
  const auto end = std::chrono::steady_clock::now() + kSlice;
  // A world is in the caches of the processor that stepped it last: where nobody waits for this worker, it stays.
  const auto gives_way = [&](Progress progress) {
    if (thread == On::kPoster) return true;
    return (progress == Progress::kAgain || std::chrono::steady_clock::now() >= end) && pool_.IsShort();
  };
  std::unique_lock lock(mutex_);
  bool again = false;
  while (!again) {
    RunUrgent(lock);
    if (work_.empty()) break;
    Work work = std::move(work_.front());
    work_.pop_front();
    lock.unlock();
    const Progress progress = work();
    if (progress == Progress::kDone) work = nullptr;
    again = gives_way(progress);
    lock.lock();
    if (work) work_.push_front(std::move(work));
  }
  scheduled_ = false;
  if (!work_.empty() || !urgent_.empty()) Schedule(lock);
}

}  // namespace genphys

#include "genphys/hosting/event_log.h"

#include "event_subscription.h"

namespace genphys {

EventLog::EventLog(WorkerPool& pool, const Stamp& now, Bounds bounds) : pool_(pool), bounds_(bounds), now_(now) {}

void EventLog::Append(const Stamp& now, std::shared_ptr<const EventChunk> chunk) {
  const std::lock_guard lock(mutex_);
  now_ = now;
  if (chunk == nullptr) return;
  chunks_.events += chunk->events().size();
  chunks_.bytes += chunk->bytes();
  chunks_.last_sequence = chunk->last_sequence();
  chunks_.kept.push_back(std::move(chunk));
  Forget();
  WakeSubscribers();
}

void EventLog::Forget() {
  while (chunks_.kept.size() > 1 && (chunks_.events > bounds_.events || chunks_.bytes > bounds_.bytes)) {
    const EventChunk& oldest = *chunks_.kept.front();
    for (const Event& event : oldest.events()) chunks_.touching_before.Follow(event);
    chunks_.stamp_before = oldest.stamp();
    chunks_.first_sequence = oldest.last_sequence() + 1;
    chunks_.events -= oldest.events().size();
    chunks_.bytes -= oldest.bytes();
    chunks_.kept.pop_front();
  }
}

void EventLog::MarkBeginning() {
  const std::lock_guard lock(mutex_);
  beginning_ = chunks_;
}

void EventLog::ForgetBeginning() {
  const std::lock_guard lock(mutex_);
  beginning_.reset();
}

void EventLog::Restart(const Stamp& now) {
  const std::lock_guard lock(mutex_);
  past_ = {now_, chunks_.last_sequence};
  now_ = now;
  if (beginning_) chunks_ = *std::exchange(beginning_, std::nullopt);
  for (const auto& subscriber : subscribers_) {
    if (const auto alive = subscriber.lock()) alive->FollowNewEpoch(past_);
  }
  WakeSubscribers();
}

void EventLog::End(const Status& why) {
  const std::lock_guard lock(mutex_);
  if (!end_) end_ = why;
  WakeSubscribers();
}

uint64_t EventLog::last_sequence() const {
  const std::lock_guard lock(mutex_);
  return chunks_.last_sequence;
}

std::shared_ptr<Subscription> EventLog::Watch(Bytes request) {
  auto subscription = std::make_shared<EventSubscription>(shared_from_this());
  pool_.Post([subscription, request = std::move(request)] { subscription->Open(request); });
  return subscription;
}

void EventLog::WakeSubscribers() {
  for (auto subscriber = subscribers_.begin(); subscriber != subscribers_.end();) {
    if (const auto alive = subscriber->lock()) {
      alive->Wake();
      ++subscriber;
    } else {
      subscriber = subscribers_.erase(subscriber);
    }
  }
}

}  // namespace genphys

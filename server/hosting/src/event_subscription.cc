#include "event_subscription.h"

#include <algorithm>
#include <exception>

#include "genphys/hosting/world_methods.h"
#include "genphys/wire/wire_format.h"

namespace genphys {

void EventSubscription::Open(const Bytes& request) {
  v1::WatchEventsRequest message;
  Status status = DecodeRequest(request, &message);
  if (status.ok()) filter_ = EventFilter(message.filter());
  const std::lock_guard lock(log_->mutex_);
  if (status.ok()) status = TakePlace(message);
  if (status.ok()) {
    open_ = true;
    log_->subscribers_.push_back(weak_from_this());
  } else if (!end_) {
    end_ = status;
  }
  Wake();
}

Status EventSubscription::TakePlace(const v1::WatchEventsRequest& request) {
  const uint64_t last = log_->chunks_.last_sequence;
  const EventLog::PastEpoch& past = log_->past_;
  if (request.has_epoch() && request.epoch() != log_->now_.epoch) {
    // Time went back since: the whole of the new epoch is news. How much of the old one was missed is known for the
    // latest only.
    if (request.epoch() == past.last_stamp.epoch && request.has_after_sequence() &&
        request.after_sequence() < past.last_sequence) {
      notices_.push_back({past.last_stamp, std::pair(request.after_sequence() + 1, past.last_sequence), {}, 0});
    }
    return absl::OkStatus();
  }
  if (!request.has_after_sequence()) {
    cursor_ = last + 1;
  } else if (request.after_sequence() > last) {
    return Refuse(Reason::kOutOfRange, "after_sequence",
                  "after_sequence is beyond the last event of this epoch, which is " + std::to_string(last));
  } else {
    cursor_ = request.after_sequence() + 1;
  }
  told_ = cursor_ - 1;
  return absl::OkStatus();
}

void EventSubscription::Next(Receiver receiver) {
  const std::lock_guard lock(log_->mutex_);
  receiver_ = std::move(receiver);
  Wake();
}

void EventSubscription::Cancel() {
  const std::lock_guard lock(log_->mutex_);
  end_ = absl::CancelledError("the subscriber is gone");
  Wake();
}

void EventSubscription::Wake() {
  if (serving_ || !receiver_ || !HasWork()) return;
  serving_ = true;
  log_->pool_.Post([self = shared_from_this()] { self->Serve(); });
}

bool EventSubscription::HasWork() const {
  if (end_) return true;
  if (!open_) return false;
  return !notices_.empty() || cursor_ <= log_->chunks_.last_sequence || !greeted_ || bookmark_due_ || log_->end_;
}

std::optional<Status> EventSubscription::End() const {
  if (end_) return end_;
  const bool all_told = notices_.empty() && cursor_ > log_->chunks_.last_sequence && greeted_;
  return all_told ? log_->end_ : std::nullopt;
}

void EventSubscription::FollowNewEpoch(const EventLog::PastEpoch& past) {
  if (encoding_) {
    // Where it stands is known once the message under way is complete. Of epochs after that it never heard.
    if (!left_while_encoding_) left_while_encoding_ = past;
    return;
  }
  const bool has_gap = !notices_.empty() && notices_.front().gap;
  const bool heard_of_it = !has_gap || notices_.front().stamp.epoch == past.last_stamp.epoch;
  if (heard_of_it) {
    const uint64_t first_lost = has_gap ? notices_.front().gap->first : cursor_;
    notices_.clear();
    if (first_lost <= past.last_sequence) {
      notices_.push_back({past.last_stamp, std::pair(first_lost, past.last_sequence), {}, 0});
    }
  }
  cursor_ = 1;
  told_ = 0;
  greeted_ = false;
}

void EventSubscription::LoseHistory() {
  const EventLog::Chunks& chunks = log_->chunks_;
  Stamp stamp = chunks.stamp_before;
  stamp.epoch = log_->now_.epoch;
  notices_.push_back({stamp, std::pair(cursor_, chunks.first_sequence - 1), {}, 0});
  notices_.push_back({stamp, std::nullopt, chunks.touching_before.Pairs(stamp.step), chunks.first_sequence});
  // A pair that touches is told to whoever wants to hear of contacts, not only of those that persist.
  std::erase_if(notices_.back().touching, [this](const Event& event) {
    const auto* touches = std::get_if<ContactPersisted>(&event.kind);
    return !filter_.Matches(touches == nullptr ? event : Event{0, 0, ContactBegan{touches->pair, {}}});
  });
  cursor_ = chunks.first_sequence;
}

EventSubscription::Draft EventSubscription::TakeDraft() {
  const EventLog::Chunks& chunks = log_->chunks_;
  if (notices_.empty() && cursor_ < chunks.first_sequence) LoseHistory();
  Draft draft;
  draft.now = log_->now_;
  draft.first_sequence = cursor_;
  if (!notices_.empty()) {
    draft.notice = std::move(notices_.front());
    notices_.pop_front();
    return draft;
  }
  draft.must_send = !greeted_ || bookmark_due_;
  auto chunk = std::partition_point(chunks.kept.begin(), chunks.kept.end(),
                                    [&](const auto& c) { return c->last_sequence() < cursor_; });
  for (size_t bytes = 0; chunk != chunks.kept.end() && bytes < EventLog::kBatchBytesMax; ++chunk) {
    bytes += (*chunk)->bytes();
    draft.chunks.push_back(*chunk);
  }
  return draft;
}

void EventSubscription::Advance(const Draft& draft, uint64_t last_sequence, bool sent) {
  if (!draft.notice) cursor_ = last_sequence + 1;
  if (sent) {
    const bool of_this_epoch = !draft.notice || draft.notice->stamp.epoch == draft.now.epoch;
    if (of_this_epoch) greeted_ = true;
    told_ = cursor_ - 1;
    bookmark_due_ = false;
  } else if (told_ + 1 != cursor_) {
    ArmBookmark();
  }
  if (left_while_encoding_) FollowNewEpoch(*std::exchange(left_while_encoding_, std::nullopt));
}

void EventSubscription::ArmBookmark() {
  if (std::exchange(bookmark_armed_, true)) return;
  const auto when = WorkerPool::Clock::now() + EventLog::kBookmarkPeriod;
  log_->pool_.PostAt(when, [weak = weak_from_this()] {
    const auto self = weak.lock();
    if (self == nullptr) return;
    const std::lock_guard lock(self->log_->mutex_);
    self->bookmark_armed_ = false;
    if (self->told_ + 1 == self->cursor_) return;
    self->bookmark_due_ = true;
    self->Wake();
  });
}

void EventSubscription::Serve() {
  try {
    while (ServeOne()) {
    }
  } catch (const std::exception& exception) {
    GiveUp(absl::InternalError(std::string("the stream failed: ") + exception.what()));
  }
}

void EventSubscription::GiveUp(const Status& why) {
  Receiver receiver;
  {
    const std::lock_guard lock(log_->mutex_);
    end_ = why;
    serving_ = false;
    encoding_ = false;
    receiver = std::exchange(receiver_, nullptr);
  }
  if (receiver) receiver({std::nullopt, why});
}

bool EventSubscription::ServeOne() {
  std::unique_lock lock(log_->mutex_);
  if (!HasWork()) {
    serving_ = false;
    return false;
  }
  if (const std::optional<Status> end = End()) {
    serving_ = false;
    const Receiver receiver = std::exchange(receiver_, nullptr);
    lock.unlock();
    receiver({std::nullopt, *end});
    return false;
  }
  Draft draft = TakeDraft();
  encoding_ = true;
  lock.unlock();

  Batch batch;
  if (draft.notice) {
    batch.message = EncodeNotice(*draft.notice);
    batch.has_events = true;
  } else {
    batch = EncodeBatch(draft);
  }
  const bool send = batch.has_events || draft.must_send;

  lock.lock();
  encoding_ = false;
  Advance(draft, batch.last_sequence, send);
  if (!send) return true;
  serving_ = false;
  const Receiver receiver = std::exchange(receiver_, nullptr);
  lock.unlock();
  receiver({std::move(batch.message), absl::OkStatus()});
  return false;
}

namespace {

void AppendStamp(const Stamp& stamp, std::string& out) {
  v1::WorldStamp message;
  stamp.Encode(&message);
  AppendField(v1::WatchEventsResponse::kStampFieldNumber, message.SerializeAsString(), out);
}

// `events` are fields of an EventBatch already.
EncodedMessage BatchMessage(const Stamp& stamp, const std::string& events, uint64_t first, uint64_t last) {
  std::string range;
  AppendVarintField(v1::EventBatch::kFirstSequenceFieldNumber, first, range);
  AppendVarintField(v1::EventBatch::kLastSequenceFieldNumber, last, range);
  std::string out;
  AppendStamp(stamp, out);
  AppendFieldHeader(v1::WatchEventsResponse::kBatchFieldNumber, events.size() + range.size(), out);
  out += events;
  out += range;
  return {MakeBytes(std::move(out))};
}

}  // namespace

EncodedMessage EventSubscription::EncodeNotice(const Notice& notice) {
  if (notice.gap) {
    std::string range;
    AppendVarintField(v1::Gap::kFirstSequenceFieldNumber, notice.gap->first, range);
    AppendVarintField(v1::Gap::kLastSequenceFieldNumber, notice.gap->second, range);
    std::string out;
    AppendStamp(notice.stamp, out);
    AppendField(v1::WatchEventsResponse::kGapFieldNumber, range, out);
    return {MakeBytes(std::move(out))};
  }
  std::string events;
  if (!notice.touching.empty()) {
    const EventChunk chunk(notice.stamp, notice.touching);
    events = chunk.Encoded(0, notice.touching.size(), false);
  }
  return BatchMessage(notice.stamp, events, notice.next_sequence, notice.next_sequence - 1);
}

EventSubscription::Batch EventSubscription::EncodeBatch(const Draft& draft) const {
  Batch batch;
  batch.last_sequence = draft.first_sequence - 1;
  Stamp stamp = draft.now;
  std::string events;
  for (const auto& chunk : draft.chunks) {
    if (events.size() >= EventLog::kBatchBytesMax) break;
    stamp = chunk->stamp();
    stamp.epoch = draft.now.epoch;
    for (size_t i = batch.last_sequence + 1 - chunk->first_sequence(); i < chunk->events().size(); ++i) {
      if (events.size() >= EventLog::kBatchBytesMax) break;
      const Event& event = chunk->events()[i];
      batch.last_sequence = event.sequence;
      if (filter_.Matches(event)) events += chunk->Encoded(i, i + 1, filter_.contact_points());
    }
  }
  batch.has_events = !events.empty();
  batch.message = BatchMessage(stamp, events, draft.first_sequence, batch.last_sequence);
  return batch;
}

}  // namespace genphys

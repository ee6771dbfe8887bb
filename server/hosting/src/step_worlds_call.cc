#include "genphys/hosting/step_worlds_call.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "genphys/v1/simulation_service.pb.h"
#include "genphys/wire/wire_format.h"

namespace genphys {
namespace {

constexpr ReplyFields kFields{v1::StepWorldsResult::kResponseFieldNumber, v1::StepWorldsResult::kRefusalFieldNumber};

// A field of StepWorldsResponse.
EncodedMessage EncodeResult(size_t index, const Result<EncodedMessage>& outcome) {
  EncodedMessage pieces = EncodeOutcome(kFields, outcome);
  std::string number;
  AppendVarintField(v1::StepWorldsResult::kIndexFieldNumber, index, number);
  std::string head;
  AppendFieldHeader(v1::StepWorldsResponse::kResultsFieldNumber, number.size() + SizeOf(pieces), head);
  head += number;
  head += pieces.front().view;
  pieces.front() = MakeBytes(std::move(head));
  return pieces;
}

WorkerPool::Clock::time_point BeforeDeadline(WorkerPool::Clock::time_point deadline) {
  using Clock = WorkerPool::Clock;
  const auto now = Clock::now();
  if (deadline == Clock::time_point::max() || deadline <= now) return deadline;
  return deadline - std::min<Clock::duration>((deadline - now) / 10, StepWorldsCall::kReplyTimeMax);
}

}  // namespace

StepWorldsCall::StepWorldsCall(std::vector<Bytes> requests, WorkerPool::Clock::time_point deadline, WorkerPool& pool,
                               ServeCall serve, Expect expect)
    : requests_(std::move(requests)),
      deadline_(BeforeDeadline(deadline)),
      pool_(pool),
      serve_(std::move(serve)),
      expect_(std::move(expect)) {}

bool StepWorldsCall::MayBegin() {
  if (cancelled_ || begun_ == requests_.size()) return false;
  if (!next_bytes_) next_bytes_ = expect_(requests_[begun_]);
  return HasRoomFor(*next_bytes_) && IsTheirTurn();
}

bool StepWorldsCall::HasRoomFor(size_t bytes) const {
  const size_t to_come = expected_bytes_ + bytes + (with_worlds_.size() + 1) * unexpected_bytes_;
  if (unsent_bytes_ + to_come <= kUnsentBytesMax) return true;
  // Replies that are larger would otherwise come one at a time.
  const bool is_read = receiver_ || unsent_.empty();
  return is_read && unsent_bytes_ < kUnsentBytesMax && with_worlds_.size() < pool_.threads();
}

// If not, it will be seen again when one has been with its world for long.
bool StepWorldsCall::IsTheirTurn() {
  const size_t most = std::max<size_t>(kWithWorldsMax, 2 * pool_.threads());
  const size_t unread = receiver_ ? 0 : unsent_.size();
  if (unread >= most) return false;
  const auto now = WorkerPool::Clock::now();
  size_t lately = 0;
  auto first = with_worlds_.end();
  while (first != with_worlds_.begin() && std::prev(first)->second.since + kLong > now) --first, ++lately;
  if (unread + lately < most) return true;
  if (first != with_worlds_.end() && !std::exchange(is_turn_timed_, true)) {
    pool_.PostAt(first->second.since + kLong, [self = shared_from_this()] {
      {
        const std::lock_guard lock(self->mutex_);
        self->is_turn_timed_ = false;
      }
      self->BeginMore();
    });
  }
  return false;
}

void StepWorldsCall::BeginMore() {
  std::unique_lock lock(mutex_);
  // A world may answer before it returns, which then only leaves word.
  if (std::exchange(beginning_, true)) return;
  while (MayBegin()) {
    const size_t index = begun_++;
    const size_t bytes = *std::exchange(next_bytes_, std::nullopt);
    with_worlds_[index] = {WorkerPool::Clock::now(), bytes};
    expected_bytes_ += bytes;
    WorldCall call{.method = WorldMethod::kStep,
                   .request = std::exchange(requests_[index], {}),
                   .deadline = deadline_,
                   .is_cancelled = [self = shared_from_this()] { return self->cancelled_.load(); },
                   .here_below = {}};
    lock.unlock();
    serve_(std::move(call),
           [self = shared_from_this(), index](const Result<EncodedMessage>& outcome) { self->Finish(index, outcome); });
    lock.lock();
  }
  beginning_ = false;
}

void StepWorldsCall::Finish(size_t index, const Result<EncodedMessage>& outcome) {
  EncodedMessage result = EncodeResult(index, outcome);
  std::unique_lock lock(mutex_);
  const size_t expected = with_worlds_.extract(index).mapped().expected_bytes;
  expected_bytes_ -= expected;
  const size_t bytes = SizeOf(result);
  unsent_bytes_ += bytes;
  if (bytes > expected) unexpected_bytes_ = std::max(unexpected_bytes_, bytes - expected);
  unsent_.push_back(std::move(result));
  Deliver(lock);
  BeginMore();
}

void StepWorldsCall::Next(Receiver receiver) {
  // Whoever receives the end may let go of this.
  const auto self = shared_from_this();
  std::unique_lock lock(mutex_);
  receiver_ = std::move(receiver);
  Deliver(lock);
  BeginMore();
}

void StepWorldsCall::Cancel() {
  const auto self = shared_from_this();
  std::unique_lock lock(mutex_);
  cancelled_ = true;
  Deliver(lock);
}

EncodedMessage StepWorldsCall::TakeMessage() {
  EncodedMessage message;
  size_t bytes = 0;
  while (!unsent_.empty() && bytes < kMessageBytesMax) {
    bytes += SizeOf(unsent_.front());
    std::move(unsent_.front().begin(), unsent_.front().end(), std::back_inserter(message));
    unsent_.pop_front();
  }
  unsent_bytes_ -= bytes;
  return message;
}

// If not, it will be told when it is.
bool StepWorldsCall::IsTimeToSend() {
  if (unsent_.size() >= kGathered || unsent_bytes_ >= kMessageBytesMax || IsDone()) return true;
  const auto next = last_sent_ + kPause;
  if (WorkerPool::Clock::now() >= next) return true;
  if (!std::exchange(is_timed_, true)) {
    pool_.PostAt(next, [self = shared_from_this()] {
      std::unique_lock again(self->mutex_);
      self->is_timed_ = false;
      self->Deliver(again);
      self->BeginMore();
    });
  }
  return false;
}

void StepWorldsCall::Deliver(std::unique_lock<std::mutex>& lock) {
  Receiver receiver;
  Delivery delivery;
  if (receiver_ && cancelled_) {
    receiver = std::exchange(receiver_, nullptr);
    delivery.end = absl::CancelledError("the caller is gone");
  } else if (receiver_ && !unsent_.empty()) {
    if (IsTimeToSend()) {
      receiver = std::exchange(receiver_, nullptr);
      delivery.message = TakeMessage();
      last_sent_ = WorkerPool::Clock::now();
    }
  } else if (receiver_ && IsDone()) {
    receiver = std::exchange(receiver_, nullptr);
  }
  lock.unlock();
  if (receiver) receiver(std::move(delivery));
}

}  // namespace genphys

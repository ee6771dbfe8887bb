#include "genphys/hosting/step_worlds_call.h"

#include <algorithm>
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

}  // namespace

bool StepWorldsCall::MayBegin() const {
  if (cancelled_ || begun_ == requests_.size()) return false;
  const size_t held = with_worlds_ + (receiver_ ? 0 : unsent_.size());
  if (held >= std::max<size_t>(kWithWorldsMax, 2 * pool_.threads())) return false;
  if (unsent_bytes_ + (with_worlds_ + 1) * largest_bytes_ <= kUnsentBytesMax) return true;
  // Replies that are larger would otherwise come one at a time.
  const bool is_read = receiver_ || unsent_.empty();
  return is_read && unsent_bytes_ < kUnsentBytesMax && with_worlds_ < pool_.threads();
}

void StepWorldsCall::BeginMore() {
  std::unique_lock lock(mutex_);
  // A world may answer before it returns, which then only leaves word.
  if (std::exchange(beginning_, true)) return;
  while (MayBegin()) {
    const size_t index = begun_++;
    ++with_worlds_;
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
  --with_worlds_;
  const size_t bytes = SizeOf(result);
  unsent_bytes_ += bytes;
  largest_bytes_ = answered_++ == 0 ? bytes : std::max(largest_bytes_, bytes);
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

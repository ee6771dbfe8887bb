#include "genphys/hosting/drive.h"

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "genphys/hosting/request_head.h"
#include "genphys/v1/simulation_service.pb.h"

namespace genphys {
namespace {

constexpr ReplyFields kFields{v1::DriveResponse::kResponseFieldNumber, v1::DriveResponse::kRefusalFieldNumber};

// While a step is under way the thread that brought it is to read the next request: only one that is over before
// another thread would have woken is done there.
constexpr std::chrono::microseconds kBriefStep{20};

// The StepRequest of a DriveRequest.
Result<Bytes> StepOf(const Bytes& request) {
  const auto payloads = ScanPayloads(v1::DriveRequest::kStepFieldNumber, request.view);
  if (!payloads) return Refuse(Reason::kInvalidValue, "", "the bytes sent are no genphys.v1.DriveRequest");
  if (payloads->empty()) return Refuse(Reason::kMissingField, "step", "step must be set");
  if (payloads->size() == 1) return Bytes{payloads->front(), request.owner};
  // A message that comes in parts is all of them, as it is for every decoder.
  std::string whole;
  for (const std::string_view part : *payloads) whole += part;
  return MakeBytes(std::move(whole));
}

}  // namespace

void Drive::Take(Bytes request, std::function<void()> ready) {
  std::unique_lock lock(mutex_);
  request_bytes_ += request.view.size();
  requests_.push_back(std::move(request));
  ready_ = std::move(ready);
  Pump(lock);
}

void Drive::CloseInput() {
  std::unique_lock lock(mutex_);
  input_closed_ = true;
  Pump(lock);
}

void Drive::End(const Status& why) {
  std::unique_lock lock(mutex_);
  if (!end_) end_ = why;
  Pump(lock);
}

void Drive::Next(Receiver receiver) {
  std::unique_lock lock(mutex_);
  sending_ = false;
  receiver_ = std::move(receiver);
  Pump(lock);
}

void Drive::Cancel() {
  std::unique_lock lock(mutex_);
  cancelled_ = true;
  Pump(lock);
}

void Drive::Pump(std::unique_lock<std::mutex>& lock) {
  if (pumping_) return;
  // Whoever receives the end may let go of this.
  const auto self = shared_from_this();
  pumping_ = true;
  while (Action action = NextAction()) {
    lock.unlock();
    action();
    action = nullptr;
    lock.lock();
  }
  pumping_ = false;
  lock.unlock();
}

Drive::Action Drive::NextAction() {
  if (ended_) return nullptr;
  if (receiver_ && cancelled_) return Finish(absl::CancelledError("the caller is gone"));
  if (cancelled_) return nullptr;
  if (receiver_ && !replies_.empty()) return SendReply();
  const size_t in_flight = requests_.size() + (at_world_ ? 1 : 0) + replies_.size() + (sending_ ? 1 : 0);
  // First, so that another thread can read while this one may be stepping.
  if (ready_ && in_flight < kInFlightMax && request_bytes_ < kBytesMax) return std::exchange(ready_, nullptr);
  if (CanDoRequest()) return DoRequest();
  if (const std::optional<Status> end = EndNow(); end && receiver_) return Finish(*end);
  return nullptr;
}

bool Drive::CanDoRequest() const {
  return !at_world_ && !end_ && !cancelled_ && !requests_.empty() && reply_bytes_ < kBytesMax;
}

Drive::Action Drive::SendReply() {
  EncodedMessage reply = std::move(replies_.front());
  replies_.pop_front();
  reply_bytes_ -= SizeOf(reply);
  sending_ = true;
  return [receiver = std::exchange(receiver_, nullptr), reply = std::move(reply)] {
    receiver({reply, absl::OkStatus()});
  };
}

Drive::Action Drive::DoRequest() {
  const Bytes request = std::move(requests_.front());
  requests_.pop_front();
  request_bytes_ -= request.view.size();
  at_world_ = true;
  return [this, request] {
    Result<Bytes> step = StepOf(request);
    if (!step.ok()) return Answer(step.status());
    // Both keep this alive until the world is done with them.
    serve_({.method = WorldMethod::kStep,
            .request = *std::move(step),
            .deadline = deadline_,
            .is_cancelled = [self = shared_from_this()] { return self->cancelled_.load(); },
            .here_below = kBriefStep},
           [self = shared_from_this()](const Result<EncodedMessage>& outcome) { self->Answer(outcome); });
  };
}

Drive::Action Drive::Finish(Status end) {
  ended_ = true;
  ready_ = nullptr;
  requests_.clear();
  replies_.clear();
  return [receiver = std::exchange(receiver_, nullptr), end = std::move(end)] { receiver({std::nullopt, end}); };
}

std::optional<Status> Drive::EndNow() const {
  if (at_world_ || !replies_.empty()) return std::nullopt;
  if (end_) return end_;
  if (input_closed_ && requests_.empty()) return absl::OkStatus();
  return std::nullopt;
}

void Drive::Answer(const Result<EncodedMessage>& outcome) {
  EncodedMessage reply = EncodeOutcome(kFields, outcome);
  std::unique_lock lock(mutex_);
  at_world_ = false;
  if (ended_) return;
  reply_bytes_ += SizeOf(reply);
  replies_.push_back(std::move(reply));
  if (pumping_) return;
  // Nobody else is at it, so this is the world's thread, which is to step and not to write: what it does next is all
  // that it sees to.
  const Action next = CanDoRequest() ? DoRequest() : nullptr;
  lock.unlock();
  if (next) next();
  pool_.Post([self = shared_from_this()] {
    std::unique_lock pump_lock(self->mutex_);
    self->Pump(pump_lock);
  });
}

}  // namespace genphys

#include "genphys/client/drive.h"

#include <utility>

#include "drive_impl.h"
#include "genphys/wire/error.h"
#include "requests.h"

namespace genphys::client {

Drive::Impl::Impl(std::shared_ptr<Connection> connection, std::string world, std::shared_ptr<Keyframes> keyframes)
    : connection_(std::move(connection)), world_(std::move(world)), keyframes_(std::move(keyframes)) {
  // Streams come back by themselves when they only read; what a lost one was sent is not known to be done.
  call_ = connection_->simulation().PrepareAsyncDrive(&context_, &queue_);
  call_->StartCall(TagOf(kStart));
  pending_ |= kStart;
  while ((pending_ & kStart) != 0) WaitForOne(std::nullopt);
}

Drive::Impl::~Impl() {
  context_.TryCancel();
  while (pending_ != 0) WaitForOne(std::nullopt);
  if (!finished_) {
    Finish();
    while (pending_ != 0) WaitForOne(std::nullopt);
  }
  queue_.Shutdown();
  void* tag = nullptr;
  bool ok = false;
  while (queue_.Next(&tag, &ok)) {
  }
}

Status Drive::Impl::Send(uint32_t steps, const StepOptions& options) {
  if (finished_) return EndOfStream();
  if (in_flight_.size() == kInFlightMax)
    return absl::FailedPreconditionError("too many are in flight: receive one first");
  auto request = std::make_unique<v1::DriveRequest>();
  request->mutable_step()->set_world(world_);
  EncodeStep(steps, options, request->mutable_step());
  InFlight& sent = in_flight_.emplace_back();
  if (options.frame && options.frame->deltas) {
    sent.keyframe = keyframes_->Find(request->mutable_step()->mutable_frame());
    sent.wishes = request->step().frame();
  }
  waiting_.push_back(std::move(request));
  WriteNext();
  // What was written before makes room by being looked at.
  while (!waiting_.empty() && WaitForOne(std::chrono::system_clock::time_point())) {
  }
  return absl::OkStatus();
}

Result<StepResult> Drive::Impl::Receive(std::optional<std::chrono::milliseconds> timeout) {
  if (in_flight_.empty()) return absl::FailedPreconditionError("nothing is in flight: send first");
  std::optional<std::chrono::system_clock::time_point> until;
  if (timeout) until = std::chrono::system_clock::now() + *timeout;
  if (response_ == nullptr && !finished_) {
    response_ = std::make_shared<v1::DriveResponse>();
    read_wanted_ = true;
    ReadNext();
  }
  while (!finished_ && (read_wanted_ || (pending_ & (kRead | kFinish)) != 0)) {
    if (!WaitForOne(until)) return absl::DeadlineExceededError("nothing came in time");
  }
  if (finished_) return EndOfStream();
  const InFlight sent = std::move(in_flight_.front());
  in_flight_.pop_front();
  const std::shared_ptr<v1::DriveResponse> response = std::exchange(response_, nullptr);
  if (response->has_refusal()) return DecodeRefusal(response->refusal());
  if (sent.wishes) keyframes_->Keep(*sent.wishes, FramePtr(response, &response->response().frame()));
  return DecodeStep(std::shared_ptr<const v1::StepResponse>(response, &response->response()), sent.keyframe);
}

Status Drive::Impl::EndOfStream() const {
  const Status status = FromGrpc(status_);
  return status.ok() ? absl::UnavailableError("the server ended the stream") : status;
}

bool Drive::Impl::WaitForOne(std::optional<std::chrono::system_clock::time_point> until) {
  void* tag = nullptr;
  bool ok = false;
  if (!until) {
    queue_.Next(&tag, &ok);
  } else if (queue_.AsyncNext(&tag, &ok, *until) != grpc::CompletionQueue::GOT_EVENT) {
    return false;
  }
  const auto operation = static_cast<unsigned>(reinterpret_cast<uintptr_t>(tag));
  pending_ &= ~operation;
  if (operation == kFinish) finished_ = true;
  if (operation == kStart) started_ = ok;
  // A write that failed leaves the end to be told by the read.
  if (operation == kWrite && ok) WriteNext();
  if ((operation == kRead || operation == kStart) && !ok) Finish();
  return true;
}

void Drive::Impl::WriteNext() {
  if (!started_ || waiting_.empty() || (pending_ & (kWrite | kFinish)) != 0 || finished_) return;
  written_ = std::move(waiting_.front());
  waiting_.pop_front();
  call_->Write(*written_, TagOf(kWrite));
  pending_ |= kWrite;
}

void Drive::Impl::ReadNext() {
  if (!started_ || !read_wanted_) return;
  read_wanted_ = false;
  call_->Read(response_.get(), TagOf(kRead));
  pending_ |= kRead;
}

void Drive::Impl::Finish() {
  read_wanted_ = false;
  call_->Finish(&status_, TagOf(kFinish));
  pending_ |= kFinish;
}

Drive::Drive(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Drive::Drive(Drive&&) noexcept = default;
Drive& Drive::operator=(Drive&&) noexcept = default;
Drive::~Drive() = default;

Status Drive::Send(uint32_t steps, const StepOptions& options) { return impl_->Send(steps, options); }

Result<StepResult> Drive::Receive(std::optional<std::chrono::milliseconds> timeout) { return impl_->Receive(timeout); }

size_t Drive::in_flight() const { return impl_->in_flight(); }

void Drive::Cancel() { impl_->Cancel(); }

}  // namespace genphys::client

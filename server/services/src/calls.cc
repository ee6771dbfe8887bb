#include "calls.h"

#include <chrono>

#include "transport.h"

namespace genphys {

std::chrono::steady_clock::time_point DeadlineOf(const grpc::CallbackServerContext& context) {
  const auto deadline = context.deadline();
  // The largest time that can be said means that there is no deadline.
  if (deadline == std::chrono::system_clock::time_point::max()) return std::chrono::steady_clock::time_point::max();
  return std::chrono::steady_clock::now() + (deadline - std::chrono::system_clock::now());
}

Reply Replier(OpenCalls& calls, grpc::ServerUnaryReactor* reactor, grpc::ByteBuffer* response) {
  calls.Begin();
  return [&calls, reactor, response](const Result<EncodedMessage>& reply) {
    if (reply.ok()) *response = ToByteBuffer(*reply);
    reactor->Finish(ToGrpcStatus(reply.status()));
    calls.End();
  };
}

grpc::ServerUnaryReactor* CallWorld(WorldDirectory& directory, OpenCalls& calls, WorldMethod method,
                                    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                    grpc::ByteBuffer* response) {
  // Each call of DefaultReactor() makes a new one.
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  directory.Handle({.method = method,
                    .request = ToBytes(*request),
                    .deadline = DeadlineOf(*context),
                    .is_cancelled = [context] { return context->IsCancelled(); }},
                   Replier(calls, reactor, response));
  return reactor;
}

void MessageStream::OnWriteDone(bool ok) {
  if (ok) {
    AskForMore();
  } else {
    Finish(grpc::Status(grpc::StatusCode::CANCELLED, "the subscriber is gone"));
  }
}

// gRPC ends a stream after its cancellation has been told, in an order that only its own code knows of; the flag tells
// it to whoever looks for races too.
void MessageStream::OnCancel() {
  subscription_->Cancel();
  was_cancelled_.store(true);
}

void MessageStream::OnDone() {
  (void)was_cancelled_.load();
  calls_.End();
  delete this;
}

void MessageStream::AskForMore() {
  subscription_->Next([this](const Delivery& delivery) {
    if (delivery.message) {
      message_ = ToByteBuffer(*delivery.message);
      StartWrite(&message_);
    } else {
      Finish(ToGrpcStatus(delivery.end));
    }
  });
}

void DriveStream::OnReadDone(bool ok) {
  if (!ok) return drive_->CloseInput();
  drive_->Take(ToBytes(request_), [this] { StartRead(&request_); });
}

void DriveStream::OnWriteDone(bool ok) {
  if (!ok) drive_->Cancel();
  AskForMore();
}

void DriveStream::OnCancel() {
  drive_->Cancel();
  was_cancelled_.store(true);
}

void DriveStream::OnDone() {
  (void)was_cancelled_.load();
  calls_.End();
  delete this;
}

void DriveStream::AskForMore() {
  drive_->Next([this](const Delivery& delivery) {
    if (delivery.message) {
      reply_ = ToByteBuffer(*delivery.message);
      StartWrite(&reply_);
    } else {
      Finish(ToGrpcStatus(delivery.end));
    }
  });
}

}  // namespace genphys

#include "calls.h"

#include <chrono>

#include "transport.h"

namespace genphys {
namespace {

std::chrono::steady_clock::time_point DeadlineOf(const grpc::CallbackServerContext& context) {
  const auto deadline = context.deadline();
  // The largest time that can be said means that there is no deadline.
  if (deadline == std::chrono::system_clock::time_point::max()) return std::chrono::steady_clock::time_point::max();
  return std::chrono::steady_clock::now() + (deadline - std::chrono::system_clock::now());
}

}  // namespace

UnaryCall* UnaryCall::ToWorld(WorldDirectory& directory, WorldMethod method, grpc::CallbackServerContext* context,
                              const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  auto* const call = new UnaryCall(response);
  directory.Handle({.method = method,
                    .request = ToBytes(*request),
                    .request_id = {},
                    .deadline = DeadlineOf(*context),
                    .cancelled = call->cancelled_},
                   call->Replier());
  return call;
}

Reply UnaryCall::Replier() {
  return [this](const Result<Bytes>& reply) {
    if (reply.ok()) *response_ = ToByteBuffer(*reply);
    Finish(ToGrpcStatus(reply.status()));
  };
}

void MessageStream::OnWriteDone(bool ok) {
  if (ok) {
    AskForMore();
  } else {
    Finish(grpc::Status(grpc::StatusCode::CANCELLED, "the subscriber is gone"));
  }
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

}  // namespace genphys

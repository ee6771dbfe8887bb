#pragma once
#include <grpcpp/grpcpp.h>

#include <atomic>
#include <chrono>
#include <memory>

#include "genphys/hosting/world_directory.h"
#include "open_calls.h"

namespace genphys {

/// When the caller stops waiting.
std::chrono::steady_clock::time_point DeadlineOf(const grpc::CallbackServerContext& context);

/// What answers a unary call, which begins here; to be called once, on any thread. `reactor` is the default one of the
/// call's context: gRPC ends any other one on a thread that has to be woken for that.
Reply Replier(OpenCalls& calls, grpc::ServerUnaryReactor* reactor, grpc::ByteBuffer* response);

/// Hands the request to the world that it names.
grpc::ServerUnaryReactor* CallWorld(WorldDirectory& directory, OpenCalls& calls, WorldMethod method,
                                    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                    grpc::ByteBuffer* response);

/// One server stream: asks its subscription for a message whenever gRPC has taken the last.
class MessageStream final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  MessageStream(OpenCalls& calls, std::shared_ptr<Subscription> subscription)
      : calls_(calls), subscription_(std::move(subscription)) {
    calls_.Begin();
    AskForMore();
  }

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  void AskForMore();

  OpenCalls& calls_;
  const std::shared_ptr<Subscription> subscription_;
  grpc::ByteBuffer message_;
  std::atomic<bool> was_cancelled_ = false;
};

/// A stream of steps: reads when its drive is ready for a request, and writes what that answers.
class DriveStream final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  DriveStream(OpenCalls& calls, std::shared_ptr<Drive> drive) : calls_(calls), drive_(std::move(drive)) {
    calls_.Begin();
    AskForMore();
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  void AskForMore();

  OpenCalls& calls_;
  const std::shared_ptr<Drive> drive_;
  grpc::ByteBuffer request_;
  grpc::ByteBuffer reply_;
  std::atomic<bool> was_cancelled_ = false;
};

}  // namespace genphys

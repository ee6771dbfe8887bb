#pragma once
#include <grpcpp/grpcpp.h>

#include <atomic>
#include <memory>

#include "genphys/hosting/world_directory.h"

namespace genphys {

/// One unary call: lives until gRPC is done with it. Whoever starts it returns it to gRPC.
class UnaryCall final : public grpc::ServerUnaryReactor {
 public:
  explicit UnaryCall(grpc::ByteBuffer* response) : response_(response) {}

  /// Hands the request to the world that it names.
  static UnaryCall* ToWorld(WorldDirectory& directory, WorldMethod method, grpc::CallbackServerContext* context,
                            const grpc::ByteBuffer* request, grpc::ByteBuffer* response);

  /// What answers the call; to be called once.
  Reply Replier();

  void OnCancel() override { cancelled_->store(true, std::memory_order_relaxed); }
  void OnDone() override { delete this; }

 private:
  grpc::ByteBuffer* const response_;
  const std::shared_ptr<std::atomic<bool>> cancelled_ = std::make_shared<std::atomic<bool>>(false);
};

/// One server stream: asks its subscription for a message whenever gRPC has taken the last.
class MessageStream final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  explicit MessageStream(std::shared_ptr<Subscription> subscription) : subscription_(std::move(subscription)) {
    AskForMore();
  }

  void OnWriteDone(bool ok) override;
  void OnCancel() override { subscription_->Cancel(); }
  void OnDone() override { delete this; }

 private:
  void AskForMore();

  const std::shared_ptr<Subscription> subscription_;
  grpc::ByteBuffer message_;
};

}  // namespace genphys

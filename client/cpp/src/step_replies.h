#pragma once
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>

#include <memory>
#include <mutex>
#include <vector>

#include "genphys/v1/simulation_service.pb.h"

namespace genphys::client {

/// The answer to a Step, whose columns lie in the memory of an earlier one where there is some.
class StepReply {
 public:
  const v1::StepResponse& message() const { return message_; }
  /// Replaces the message; false if the bytes are none.
  bool Decode(grpc::ByteBuffer* bytes);

 private:
  v1::StepResponse message_;
  std::unique_ptr<v1::Frame> spare_;  // of an earlier message, if this one has no frame
};

/// Where the answers of a connection come from, and go back to once nobody looks at them any more: to allocate the
/// columns of a frame of a thousand entities anew takes as long as to copy them. Thread-safe.
class StepReplies : public std::enable_shared_from_this<StepReplies> {
 public:
  /// Holds what it held when it was last given back.
  std::shared_ptr<StepReply> Take();

 private:
  void GiveBack(std::unique_ptr<StepReply> reply);

  std::mutex mutex_;
  std::vector<std::unique_ptr<StepReply>> spare_;
};

using StepStub = grpc::TemplatedGenericStub<v1::StepRequest, StepReply>;

}  // namespace genphys::client

template <>
class grpc::SerializationTraits<genphys::client::StepReply> {
 public:
  static grpc::Status Deserialize(grpc::ByteBuffer* bytes, genphys::client::StepReply* reply) {
    const bool good = reply->Decode(bytes);
    bytes->Clear();  // gRPC leaves that to us
    if (good) return grpc::Status::OK;
    return {grpc::StatusCode::INTERNAL, "the server's answer to Step is none"};
  }
};

#pragma once
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <grpcpp/grpcpp.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "genphys/status.h"

namespace genphys::testing {

/// Every method of the contract, in order of service and rpc.
std::vector<const google::protobuf::MethodDescriptor*> Methods();

/// What came back: the only reply, or the first message of a stream.
struct Answer {
  grpc::Status status;
  std::string reply;
};

/// Sends `request`, whatever bytes it is, to any method. A stream is left after its first message.
Answer CallAny(const std::shared_ptr<grpc::Channel>& channel, const google::protobuf::MethodDescriptor& method,
               const std::string& request);

/// "accepted", or "REASON field" of a refusal. Anything that a refusal should not look like is told instead: the wrong
/// code, other than one ErrorInfo, a BadRequest that blames another field.
std::string VerdictOf(const grpc::Status& status);
/// The same words for what is expected.
std::string VerdictOf(const std::optional<Refusal>& refusal);

/// Path of the first number in `message` that is not finite, the columns of a frame or of ray hits included; empty when
/// there is none.
std::string FirstNotFinite(const google::protobuf::Message& message);

}  // namespace genphys::testing

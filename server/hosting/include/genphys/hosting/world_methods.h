#pragma once
#include <google/protobuf/message.h>

#include <string_view>

#include "genphys/hosting/request_head.h"
#include "genphys/hosting/world_host.h"
#include "genphys/status.h"

namespace genphys {

/// What the contract says about a method.
struct WorldMethodInfo {
  std::string_view name;  // "genphys.v1.SimulationService.Step"
  const google::protobuf::Descriptor* request = nullptr;
  RequestHeadFields head;
};

const WorldMethodInfo& InfoOf(WorldMethod method);

/// Decodes `request` into the empty `message` and checks its declared limits. INVALID_VALUE for bytes that are no such
/// message.
Status DecodeRequest(const Bytes& request, google::protobuf::Message* message);

/// `message`, encoded.
Bytes EncodeReply(const google::protobuf::Message& message);

/// What DecodeRequest() says of a request that a method would take, or OK.
Status CheckRequest(WorldMethod method, const Bytes& request);

}  // namespace genphys

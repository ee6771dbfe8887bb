#pragma once
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <memory>
#include <string>
#include <vector>

#include "genphys/v1/limits.pb.h"

namespace genphys {

/// Types of the requests of all services of the contract, in order of service and rpc.
std::vector<const google::protobuf::Descriptor*> RequestTypes();

/// A request of `type` with what it must have and nothing else.
std::unique_ptr<google::protobuf::Message> MinimalRequest(const google::protobuf::Descriptor* type);

/// A field that a client can set.
struct ReachableField {
  const google::protobuf::FieldDescriptor* field;
  /// With [0] behind everything repeated, as the path of a refusal would name it.
  std::string path;
  /// Declared on it, or taken over from the field that holds its message.
  const v1::Limit* limit;

  bool is_number() const;
  bool is_bounded_number() const { return is_number() && limit->has_min() && limit->has_max(); }
};

/// Every field of `type` and of the messages in it, in the order of their declaration.
std::vector<ReachableField> ReachableFields(const google::protobuf::Descriptor* type);

}  // namespace genphys

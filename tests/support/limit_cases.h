#pragma once
#include <google/protobuf/message.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "genphys/status.h"

namespace genphys {

/// A request that probes what one field accepts.
struct LimitCase {
  const google::protobuf::Message& request;
  /// Path of the probed field, or the name of a oneof in its place.
  std::string field;
  /// What was done to it, as in "above max".
  std::string probe;
  /// How it must be refused. Nothing: it lies within the declared limits, which says nothing about what it means.
  std::optional<Refusal> refusal;
};

struct LimitCaseOptions {
  /// Cases with more bytes than this in one field are left out: a server also has a limit for messages.
  size_t field_bytes_max = size_t{1} << 20;
  /// Called with every message that the generator adds to a request, its required fields set, before anything in it is
  /// probed: to put in ids of things that exist, or what a message needs to make sense.
  std::function<void(google::protobuf::Message& added)> complete;
};

/// Sets what `message` must have: required fields, and the first alternative of every oneof.
void FillRequired(google::protobuf::Message& message);

/// Calls `visit` with every case for every field that can be reached from `sample`, which must itself be valid. A case
/// is the sample, with the messages added that lead to the field, and one thing done to the field. Everything is read
/// from the descriptors and the declared limits: a new field is covered without anyone remembering it.
void ForEachLimitCase(const google::protobuf::Message& sample, const LimitCaseOptions& options,
                      const std::function<void(const LimitCase&)>& visit);

}  // namespace genphys

#pragma once
#include <google/protobuf/descriptor.h>
#include <re2/re2.h>

#include <cfloat>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "genphys/v1/limits.pb.h"

namespace genphys {

struct MessageRules;

/// What one field accepts, read once from its options.
struct FieldRules {
  const google::protobuf::FieldDescriptor* field = nullptr;
  /// Copies of what the descriptor says, which it looks up anew each time it is asked.
  google::protobuf::FieldDescriptor::CppType type{};
  bool repeated = false;
  bool has_presence = false;
  /// As declared on the field or taken over from the field that holds its message; never null.
  const v1::Limit* limit = nullptr;
  /// Refused when unset. A message that takes over a limit does not take over this.
  bool required = false;
  /// Inclusive and finite, so that a value within them is finite too.
  double min = -DBL_MAX;
  double max = DBL_MAX;
  /// Null: any text.
  std::shared_ptr<const RE2> pattern;
  /// The column that decides the number of rows; null when this one does.
  const google::protobuf::FieldDescriptor* rows_as = nullptr;
  /// Of the message that the field holds; null for other fields.
  const MessageRules* message = nullptr;
};

/// A field, or a oneof of which exactly one member is set.
struct RuleGroup {
  /// Null for a field that stands alone.
  const google::protobuf::OneofDescriptor* oneof = nullptr;
  /// One field, or the members of the oneof by their index in it.
  std::vector<FieldRules> fields;
};

/// What one message accepts, in order of field numbers. Fields that accept everything are left out.
struct MessageRules {
  std::vector<RuleGroup> groups;
};

/// The rules of `descriptor`, valid until the program ends; null when it is no top-level message of the contract.
/// Thread-safe. The first call reads the whole contract.
const MessageRules* RulesOf(const google::protobuf::Descriptor* descriptor);

}  // namespace genphys

#pragma once
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "genphys/status.h"
#include "genphys/v1/entity.pb.h"
#include "support/filled_message.h"

namespace genphys {

/// Success if both are the same in every field; else the fields that differ.
inline testing::AssertionResult SameMessage(const google::protobuf::Message& expected,
                                            const google::protobuf::Message& actual) {
  std::string differences;
  google::protobuf::util::MessageDifferencer differencer;
  differencer.ReportDifferencesToString(&differences);
  if (differencer.Compare(expected, actual)) return testing::AssertionSuccess();
  return testing::AssertionFailure() << differences;
}

/// Reason and field path of a refusal, as in "INVALID_VALUE update_mask".
inline std::string Verdict(const Status& status) {
  const std::optional<Refusal> refusal = RefusalOf(status);
  if (!refusal) return status.ok() ? "accepted" : MessageOf(status);
  return std::string(NameOf(refusal->reason)) + " " + refusal->field;
}

/// Every field set.
inline v1::Entity FilledEntity(const std::string& shape = "sphere") {
  v1::Entity entity;
  FillEveryField(&entity, {{"genphys.v1.Shape.kind", shape}});
  return entity;
}

}  // namespace genphys

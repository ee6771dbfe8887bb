#include "genphys/wire/error.h"

#include <string>

#include "absl/strings/numbers.h"
#include "early_end_message.h"
#include "enums.h"
#include "google/rpc/error_details.pb.h"

namespace genphys {
namespace {

constexpr char kFieldKey[] = "field";
constexpr char kStepsDoneKey[] = "steps_done";
constexpr char kStepKey[] = "step";
constexpr char kCommandsDoneKey[] = "commands_done";
constexpr char kCreatedKey[] = "created_ids";

using Metadata = google::protobuf::Map<std::string, std::string>;

void TellEarlyEnd(const EarlyEnd& end, Metadata& metadata) {
  metadata[kStepsDoneKey] = std::to_string(end.steps_done);
  metadata[kStepKey] = std::to_string(end.step);
  if (end.commands_done) metadata[kCommandsDoneKey] = std::to_string(*end.commands_done);
  const std::optional<std::string> created = CreatedText(end.created);
  if (created && !created->empty()) metadata[kCreatedKey] = *created;
}

std::optional<EarlyEnd> EarlyEndIn(const Metadata& metadata) {
  const auto steps_done = metadata.find(kStepsDoneKey), step = metadata.find(kStepKey);
  const auto created = metadata.find(kCreatedKey);
  EarlyEnd end;
  if (steps_done == metadata.end() || !absl::SimpleAtoi(steps_done->second, &end.steps_done)) return std::nullopt;
  if (step == metadata.end() || !absl::SimpleAtoi(step->second, &end.step)) return std::nullopt;
  uint32_t commands = 0;
  const auto commands_done = metadata.find(kCommandsDoneKey);
  if (commands_done != metadata.end() && absl::SimpleAtoi(commands_done->second, &commands)) {
    end.commands_done = commands;
  }
  if (created != metadata.end()) end.created = CreatedOf(created->second);
  return end;
}

Reason ReasonOf(std::string_view name) {
  v1::ErrorReason reason = v1::ERROR_REASON_UNSPECIFIED;
  v1::ErrorReason_Parse("ERROR_REASON_" + std::string(name), &reason);
  return DecodeReason(reason);
}

}  // namespace

v1::ErrorReason EncodeReason(Reason reason) { return static_cast<v1::ErrorReason>(reason); }

Reason DecodeReason(v1::ErrorReason reason) {
  return v1::ErrorReason_IsValid(reason) ? static_cast<Reason>(reason) : Reason::kUnspecified;
}

google::rpc::Status EncodeStatus(const Status& status) {
  google::rpc::Status encoded;
  encoded.set_code(static_cast<int>(status.code()));
  encoded.set_message(MessageOf(status));
  const std::optional<Refusal> refusal = RefusalOf(status);
  const std::optional<EarlyEnd> early_end = EarlyEndOf(status);
  if (!refusal && !early_end) return encoded;
  google::rpc::ErrorInfo info;
  info.set_reason(std::string(NameOf(refusal.value_or(Refusal{}).reason)));
  info.set_domain(std::string(kErrorDomain));
  if (early_end) TellEarlyEnd(*early_end, *info.mutable_metadata());
  if (refusal && !refusal->field.empty()) {
    (*info.mutable_metadata())[kFieldKey] = refusal->field;
    google::rpc::BadRequest request;
    google::rpc::BadRequest::FieldViolation* violation = request.add_field_violations();
    violation->set_field(refusal->field);
    violation->set_description(MessageOf(status));
    encoded.add_details()->PackFrom(request);
  }
  encoded.add_details()->PackFrom(info);
  return encoded;
}

Status DecodeStatus(const google::rpc::Status& status) {
  const Status plain(static_cast<absl::StatusCode>(status.code()), status.message());
  for (const google::protobuf::Any& detail : status.details()) {
    google::rpc::ErrorInfo info;
    if (!detail.Is<google::rpc::ErrorInfo>() || !detail.UnpackTo(&info) || info.domain() != kErrorDomain) continue;
    const Reason reason = ReasonOf(info.reason());
    const auto field = info.metadata().find(kFieldKey);
    const std::string path = field == info.metadata().end() ? "" : field->second;
    // A reason that this build does not know must not change the code that came with it.
    const Status known = reason == Reason::kUnspecified ? plain : Refuse(reason, path, status.message());
    const std::optional<EarlyEnd> early_end = EarlyEndIn(info.metadata());
    return early_end ? WithEarlyEnd(known, *early_end) : known;
  }
  return plain;
}

void EncodeError(const Status& status, v1::Error* out) {
  if (const std::optional<Refusal> refusal = RefusalOf(status)) {
    out->set_reason(EncodeReason(refusal->reason));
    out->set_field(refusal->field);
  }
  out->set_message(MessageOf(status));
}

void EncodeRefusal(const Status& status, v1::Refusal* out) {
  out->set_code(static_cast<int>(status.code()));
  if (const std::optional<Refusal> refusal = RefusalOf(status)) {
    out->set_reason(EncodeReason(refusal->reason));
    out->set_field(refusal->field);
  }
  out->set_message(MessageOf(status));
  if (const std::optional<EarlyEnd> end = EarlyEndOf(status)) EncodeEarlyEnd(*end, out->mutable_early_end());
}

Status DecodeRefusal(const v1::Refusal& refusal) {
  const Reason reason = DecodeReason(refusal.reason());
  // A reason that this build does not know must not change the code that came with it.
  const Status status = reason == Reason::kUnspecified
                            ? Status(static_cast<absl::StatusCode>(refusal.code()), refusal.message())
                            : Refuse(reason, refusal.field(), refusal.message());
  return refusal.has_early_end() ? WithEarlyEnd(status, DecodeEarlyEnd(refusal.early_end())) : status;
}

}  // namespace genphys

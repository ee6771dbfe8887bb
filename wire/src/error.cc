#include "genphys/wire/error.h"

#include <string>

#include "absl/strings/cord.h"
#include "absl/types/optional.h"
#include "enums.h"
#include "google/rpc/error_details.pb.h"

namespace genphys {
namespace {

constexpr char kFieldKey[] = "field";
constexpr char kStepsDoneKey[] = "steps_done";
constexpr char kStepKey[] = "step";
// Both numbers of StepsDone as text, with a space between.
constexpr char kStepsDoneUrl[] = "genphys/steps_done";

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

Status WithStepsDone(Status status, const StepsDone& steps) {
  status.SetPayload(kStepsDoneUrl, absl::Cord(std::to_string(steps.done) + ' ' + std::to_string(steps.step)));
  return status;
}

google::rpc::Status EncodeStatus(const Status& status) {
  google::rpc::Status encoded;
  encoded.set_code(static_cast<int>(status.code()));
  encoded.set_message(MessageOf(status));
  const std::optional<Refusal> refusal = RefusalOf(status);
  const absl::optional<absl::Cord> steps = status.GetPayload(kStepsDoneUrl);
  if (!refusal && !steps) return encoded;
  google::rpc::ErrorInfo info;
  info.set_reason(std::string(NameOf(refusal.value_or(Refusal{}).reason)));
  info.set_domain(std::string(kErrorDomain));
  if (steps) {
    const std::string text(*steps);
    (*info.mutable_metadata())[kStepsDoneKey] = text.substr(0, text.find(' '));
    (*info.mutable_metadata())[kStepKey] = text.substr(text.find(' ') + 1);
  }
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
  for (const google::protobuf::Any& detail : status.details()) {
    google::rpc::ErrorInfo info;
    if (!detail.Is<google::rpc::ErrorInfo>() || !detail.UnpackTo(&info) || info.domain() != kErrorDomain) continue;
    const Reason reason = ReasonOf(info.reason());
    const auto field = info.metadata().find(kFieldKey);
    const std::string path = field == info.metadata().end() ? "" : field->second;
    // A reason that this build does not know must not change the code that came with it.
    if (reason != Reason::kUnspecified) return Refuse(reason, path, status.message());
  }
  return Status(static_cast<absl::StatusCode>(status.code()), status.message());
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
}

Status DecodeRefusal(const v1::Refusal& refusal) {
  const Reason reason = DecodeReason(refusal.reason());
  // A reason that this build does not know must not change the code that came with it.
  if (reason != Reason::kUnspecified) return Refuse(reason, refusal.field(), refusal.message());
  return Status(static_cast<absl::StatusCode>(refusal.code()), refusal.message());
}

}  // namespace genphys

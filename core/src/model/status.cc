#include "genphys/status.h"

#include <array>
#include <utility>

#include "absl/strings/cord.h"
#include "genphys/capabilities.h"
#include "model/cat.h"

namespace genphys {
namespace {

// One byte of reason, then the field path.
constexpr char kPayloadUrl[] = "genphys/refusal";

struct ReasonRow {
  Reason reason;
  absl::StatusCode code;
  std::string_view name;
};

using absl::StatusCode;
constexpr std::array kReasons{
    ReasonRow{Reason::kUnspecified, StatusCode::kUnknown, "UNSPECIFIED"},
    ReasonRow{Reason::kStaleId, StatusCode::kNotFound, "STALE_ID"},
    ReasonRow{Reason::kUnsupportedFeature, StatusCode::kUnimplemented, "UNSUPPORTED_FEATURE"},
    ReasonRow{Reason::kNotFinite, StatusCode::kInvalidArgument, "NOT_FINITE"},
    ReasonRow{Reason::kNotUnitLength, StatusCode::kInvalidArgument, "NOT_UNIT_LENGTH"},
    ReasonRow{Reason::kLimitExceeded, StatusCode::kResourceExhausted, "LIMIT_EXCEEDED"},
    ReasonRow{Reason::kHistoryGone, StatusCode::kOutOfRange, "HISTORY_GONE"},
    ReasonRow{Reason::kWorldNotPaused, StatusCode::kFailedPrecondition, "WORLD_NOT_PAUSED"},
    ReasonRow{Reason::kDraining, StatusCode::kUnavailable, "DRAINING"},
    ReasonRow{Reason::kMissingField, StatusCode::kInvalidArgument, "MISSING_FIELD"},
    ReasonRow{Reason::kOutOfRange, StatusCode::kInvalidArgument, "OUT_OF_RANGE"},
    ReasonRow{Reason::kWorldNotFound, StatusCode::kNotFound, "WORLD_NOT_FOUND"},
    ReasonRow{Reason::kAlreadyExists, StatusCode::kAlreadyExists, "ALREADY_EXISTS"},
    ReasonRow{Reason::kStepMismatch, StatusCode::kFailedPrecondition, "STEP_MISMATCH"},
    ReasonRow{Reason::kDiverged, StatusCode::kAborted, "DIVERGED"},
    ReasonRow{Reason::kPoisoned, StatusCode::kAborted, "POISONED"},
    ReasonRow{Reason::kBudgetExceeded, StatusCode::kResourceExhausted, "BUDGET_EXCEEDED"},
    ReasonRow{Reason::kSnapshotIncompatible, StatusCode::kFailedPrecondition, "SNAPSHOT_INCOMPATIBLE"},
    ReasonRow{Reason::kWorldFaulted, StatusCode::kFailedPrecondition, "WORLD_FAULTED"},
    ReasonRow{Reason::kEntityNotFound, StatusCode::kNotFound, "ENTITY_NOT_FOUND"},
    ReasonRow{Reason::kInvalidValue, StatusCode::kInvalidArgument, "INVALID_VALUE"},
};

constexpr bool InOrder() {
  for (size_t i = 0; i < kReasons.size(); ++i) {
    if (static_cast<size_t>(kReasons[i].reason) != i) return false;
  }
  return true;
}
static_assert(InOrder(), "the table is indexed by reason");

Status Make(absl::StatusCode code, const Refusal& refusal, std::string_view message) {
  Status status(code, absl::string_view(message.data(), message.size()));
  std::string payload(1, static_cast<char>(refusal.reason));
  payload += refusal.field;
  status.SetPayload(kPayloadUrl, absl::Cord(payload));
  return status;
}

}  // namespace

absl::StatusCode CodeOf(Reason reason) { return kReasons[static_cast<size_t>(reason)].code; }

std::string_view NameOf(Reason reason) { return kReasons[static_cast<size_t>(reason)].name; }

Status Refuse(Reason reason, std::string_view field, std::string_view message) {
  return Make(CodeOf(reason), {reason, std::string(field)}, message);
}

Status UnsupportedFeature(Feature feature, std::string_view engine, std::string_view field) {
  return Refuse(Reason::kUnsupportedFeature, field, Cat("engine \"", engine, "\" does not support ", NameOf(feature)));
}

std::optional<Refusal> RefusalOf(const Status& status) {
  const auto payload = status.GetPayload(kPayloadUrl);
  if (!payload || payload->empty()) return std::nullopt;
  const std::string bytes(*payload);
  return Refusal{static_cast<Reason>(bytes[0]), bytes.substr(1)};
}

std::string MessageOf(const Status& status) { return std::string(status.message()); }

Status WithFieldPrefix(const Status& status, std::string_view prefix) {
  std::optional<Refusal> refusal = RefusalOf(status);
  if (!refusal) return status;
  refusal->field = refusal->field.empty() ? std::string(prefix) : Cat(prefix, ".", refusal->field);
  return Make(status.code(), *refusal, MessageOf(status));
}

}  // namespace genphys

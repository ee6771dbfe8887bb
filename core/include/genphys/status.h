#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace genphys {

using Status = absl::Status;
template <typename T>
using Result = absl::StatusOr<T>;

enum class Feature : uint8_t;

/// Why something was refused. Stable and never reused; the wire carries the same list. kHistoryGone, kPoisoned and
/// kSnapshotIncompatible are reserved: nothing gives them yet.
enum class Reason : uint8_t {
  kUnspecified,
  kStaleId,
  kUnsupportedFeature,
  kNotFinite,
  kNotUnitLength,
  kLimitExceeded,
  kHistoryGone,
  kWorldNotPaused,
  kDraining,
  kMissingField,
  kOutOfRange,
  kWorldNotFound,
  kAlreadyExists,
  kStepMismatch,
  kDiverged,
  kPoisoned,
  kBudgetExceeded,
  kSnapshotIncompatible,
  kWorldFaulted,
  kEntityNotFound,
  kInvalidValue,
};

/// What a refusing Status carries besides its code and message.
struct Refusal {
  Reason reason = Reason::kUnspecified;
  /// Path of the offending field, empty when no field is to blame.
  std::string field;
};

/// A Status with the code that belongs to `reason`; `message` is for people.
Status Refuse(Reason reason, std::string_view field, std::string_view message);
/// UNIMPLEMENTED, naming the feature that `engine` lacks.
Status UnsupportedFeature(Feature feature, std::string_view engine, std::string_view field);

/// The refusal inside `status`, or nothing for OK and for errors of other origin.
std::optional<Refusal> RefusalOf(const Status& status);

/// What `status` says to people.
std::string MessageOf(const Status& status);

/// The same refusal with `prefix` and a dot put before its field path.
Status WithFieldPrefix(const Status& status, std::string_view prefix);

/// The code that belongs to `reason`.
absl::StatusCode CodeOf(Reason reason);
/// UPPER_SNAKE name of `reason`, as the wire spells it without its prefix.
std::string_view NameOf(Reason reason);

}  // namespace genphys

/// Leaves the enclosing function with the status of `expression` unless that is OK.
#define GENPHYS_RETURN_IF_ERROR(expression)                                                              \
  do {                                                                                                   \
    if (::genphys::Status genphys_status_ = (expression); !genphys_status_.ok()) return genphys_status_; \
  } while (false)

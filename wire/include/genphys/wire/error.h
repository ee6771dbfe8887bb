#pragma once
#include <cstdint>
#include <string_view>

#include "genphys/status.h"
#include "genphys/v1/error.pb.h"
#include "google/rpc/status.pb.h"

namespace genphys {

/// The domain of every ErrorInfo that is ours.
inline constexpr std::string_view kErrorDomain = "genphys";

/// How far a call of several steps came before it failed.
struct StepsDone {
  uint32_t done = 0;  // of this call
  uint64_t step = 0;  // of the world then
};

/// `status`, which is not OK, with that to tell.
Status WithStepsDone(Status status, const StepsDone& steps);

/// `status` as a client receives it in grpc-status-details-bin: code and message, and for a refusal and for what has
/// StepsDone one ErrorInfo (domain "genphys", metadata "field", "steps_done" and "step" where there is one) and, with a
/// field to blame, a BadRequest.
google::rpc::Status EncodeStatus(const Status& status);

/// The same status with its refusal restored. Details of other domains and unknown reasons are left out.
Status DecodeStatus(const google::rpc::Status& status);

/// Why one command of a batch was refused. Errors that are no refusal have the reason UNSPECIFIED.
void EncodeError(const Status& status, v1::Error* out);

/// `status` as a message of a stream. Errors that are no refusal have the reason UNSPECIFIED.
void EncodeRefusal(const Status& status, v1::Refusal* out);

/// The status that EncodeRefusal() was given.
Status DecodeRefusal(const v1::Refusal& refusal);

/// The same reason on the wire.
v1::ErrorReason EncodeReason(Reason reason);

/// The same reason in the model; UNSPECIFIED for one that this build does not know.
Reason DecodeReason(v1::ErrorReason reason);

}  // namespace genphys

#pragma once
#include <string_view>

#include "genphys/status.h"
#include "genphys/v1/error.pb.h"
#include "genphys/wire/early_end.h"
#include "google/rpc/status.pb.h"

namespace genphys {

/// The domain of every ErrorInfo that is ours.
inline constexpr std::string_view kErrorDomain = "genphys";

/// `status` as a client receives it in grpc-status-details-bin: code and message, and for a refusal and for what has
/// an EarlyEnd one ErrorInfo (domain "genphys", metadata "field", "steps_done", "step", "commands_done" and
/// "created_ids" where there is one) and, with a field to blame, a BadRequest.
google::rpc::Status EncodeStatus(const Status& status);

/// The same status with its refusal and its EarlyEnd restored. Details of other domains and unknown reasons are left
/// out.
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

#pragma once
#include "genphys/status.h"

namespace google::protobuf {
class Message;
}

namespace genphys {

/// OK, or the first violation, in order of field numbers, of what `message` and all that it holds declare in their
/// `limit` options and of the rules at the head of limits.proto. The refusal names the path of the field, as in
/// "commands[3].set_pose.pose.position.x"; a column's scalars are counted from its beginning, as in "forces[12]".
/// A message that is no top-level message of genphys.v1 is refused. Thread-safe. The first call reads the options of
/// the whole contract; later ones take no lock.
Status ValidateLimits(const google::protobuf::Message& message);

}  // namespace genphys

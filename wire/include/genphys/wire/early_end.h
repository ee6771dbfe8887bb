#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "genphys/ids.h"
#include "genphys/status.h"

namespace genphys {

/// How far a call of several steps came before it failed: its commands are done, or the first of them.
struct EarlyEnd {
  uint32_t steps_done = 0;                     // of this call
  uint64_t step = 0;                           // of the world then
  std::vector<CreatedId> created = {};         // one per command, null where it created nothing; empty: not told
  std::optional<uint32_t> commands_done = {};  // set: these, and no others
  bool operator==(const EarlyEnd&) const = default;
};

/// `status`, which is not OK, with that to tell.
Status WithEarlyEnd(Status status, const EarlyEnd& end);

/// What WithEarlyEnd() gave to `status`, here or on the other side of a connection.
std::optional<EarlyEnd> EarlyEndOf(const Status& status);

}  // namespace genphys

#pragma once
#include <functional>

#include "genphys/hosting/subscription.h"
#include "genphys/hosting/world_host.h"

namespace genphys {

/// Hands a call to the world that it names, as WorldDirectory::Handle() does.
using ServeCall = std::function<void(WorldCall, Reply)>;

/// Where a message of a stream has what the call of one request alone would have answered.
struct ReplyFields {
  int response = 0;
  int refusal = 0;
};

/// The fields of that message for `outcome`; a reply is shared, not copied.
EncodedMessage EncodeOutcome(const ReplyFields& fields, const Result<EncodedMessage>& outcome);

}  // namespace genphys

#pragma once
#include <functional>
#include <optional>

#include "genphys/hosting/bytes.h"
#include "genphys/status.h"

namespace genphys {

/// One message of a stream, or how the stream ends.
struct Delivery {
  std::optional<EncodedMessage> message;
  Status end;  // read only without a message; OK: nothing more will come
};

/// One subscriber's place in a stream of encoded messages. The subscriber asks for each message, so the stream never
/// holds more than one for it: what a slow one misses is up to the stream. Thread-safe.
class Subscription {
 public:
  using Receiver = std::function<void(Delivery)>;

  virtual ~Subscription() = default;

  /// Calls `receiver` once, when there is a message or the stream ends: on any thread, perhaps before this returns.
  /// The next call comes after that, and none after the end.
  virtual void Next(Receiver receiver) = 0;

  /// The subscriber is gone: a waiting receiver is told CANCELLED.
  virtual void Cancel() = 0;
};

}  // namespace genphys

#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "genphys/client/options.h"
#include "genphys/client/world.h"
#include "genphys/status.h"

namespace genphys::client {

/// Steps of one world without waiting for the result of each, so that the world steps while this program works and the
/// next request is there when it is done. Results come in the order of sending. One thread uses it, any may Cancel().
/// Other calls to the world take their own way: one that is to come after a request is made after its result.
///
///   drive.Send(), drive.Send();
///   while (running) { result = drive.Receive(); drive.Send(1, {.commands = ...}); }
class Drive {
 public:
  /// Requests that were sent and whose results were not received.
  static constexpr size_t kInFlightMax = 16;

  Drive(Drive&&) noexcept;
  Drive& operator=(Drive&&) noexcept;
  /// Ends the stream. Of what was sent and not received, some may be done.
  ~Drive();

  /// Asks for steps, as World::Step() does, and returns at once; a deadline in `options` is not heeded.
  /// FAILED_PRECONDITION while kInFlightMax are in flight.
  Status Send(uint32_t steps = 1, const StepOptions& options = {});

  /// Waits for the result of the oldest request in flight. A refusal, or DIVERGED, is of that one: the requests behind
  /// it are done all the same, unless their expected_step says otherwise. DEADLINE_EXCEEDED after `timeout`: ask again.
  /// Any other error ends the stream: nobody knows how many of those in flight were done. FAILED_PRECONDITION if none
  /// is.
  Result<StepResult> Receive(std::optional<std::chrono::milliseconds> timeout = std::nullopt);

  size_t in_flight() const;
  /// A Receive() that waits returns CANCELLED, and so do all later ones.
  void Cancel();

 private:
  friend class World;
  class Impl;
  explicit Drive(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace genphys::client

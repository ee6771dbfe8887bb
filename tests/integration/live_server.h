#pragma once
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "genphys/client/client.h"
#include "support/test_server.h"

namespace genphys::testing {

/// A genphysd of this build in a process of its own, as its users have it. Its end fails the test if it ended by itself
/// before or if a sanitizer had something to say.
class LiveServer {
 public:
  LiveServer();
  ~LiveServer();

  /// As a client takes it.
  const std::string& address() const { return address_; }
  /// A connection of its own.
  client::Server Connect() const;

 private:
  TemporaryFolder folder_;
  ServerProcess process_;
  std::string address_;
};

/// The value of `result`; without one the test ends here and fails.
template <typename T>
T Value(Result<T> result) {
  if (!result.ok()) throw std::runtime_error(result.status().ToString());
  return *std::move(result);
}

/// Ends and fails the test unless `status` is OK.
inline void MustBeOk(const Status& status) {
  if (!status.ok()) throw std::runtime_error(status.ToString());
}

/// A world on `engine` with earth's gravity 9.81 m/s^2, a floor and a state hash in every stamp.
client::WorldOptions WorldOn(const std::string& engine);

/// Columns of `frame` for one entity, which it must have.
Vector3 PositionIn(const client::Frame& frame, EntityId id);
Vector3 VelocityIn(const client::Frame& frame, EntityId id);
Vector3 SpinIn(const client::Frame& frame, EntityId id);
bool AsleepIn(const client::Frame& frame, EntityId id);

/// Reads `stream` until it has told of event `last_sequence`. Fails the test if anything is missing, comes twice or is
/// out of order.
std::vector<Event> ReadEvents(client::EventStream& stream, uint64_t last_sequence);

}  // namespace genphys::testing

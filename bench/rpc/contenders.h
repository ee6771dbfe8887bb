#pragma once
#include <grpcpp/channel.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "echo.h"
#include "genphys/client/client.h"
#include "genphys/registry.h"
#include "genphys/world.h"
#include "scenes.h"
#include "support/child_process.h"
#include "support/must.h"

// The four ways in which the same step is measured. Each has a world of its own, or none, so that all of them are at
// the same step when they take the next one. Failures are std::runtime_errors.

namespace genphys::bench {

/// Durations in microseconds.
using Times = std::vector<double>;

/// A world of `scene` at the server.
client::World MakeWorld(const std::string& address, const Scene& scene);

/// Throws unless `frame` has the bits of `state`.
void CheckSame(const StateArrays& state, const client::Frame& frame, const std::string& whose);

/// The bytes of one call of Step.
struct Exchange {
  std::string request;
  std::string reply;
};

/// The step as a function call: no server, no bytes.
class InProcess {
 public:
  InProcess(const BackendRegistry& registry, const Scene& scene);

  void Advance(uint32_t steps);
  Times Measure(uint32_t steps);
  const StateArrays& state() const { return world_->state(); }
  /// Contact points now.
  size_t contacts() const { return world_->contacts().points.size(); }

 private:
  void StepOnce();

  std::unique_ptr<World> world_;
};

/// The cycle through the C++ client, as a user's program makes it: a step, and a frame with poses and velocities of all
/// entities and the events in return.
class CppCycle {
 public:
  CppCycle(const std::string& address, const Scene& scene);

  void Advance(uint32_t steps);
  Times Measure(uint32_t steps);
  /// Takes one step with a plain stub, to see the bytes that such a cycle sends and receives.
  Exchange Capture();
  /// The state as it is now.
  client::Frame Look();

 private:
  client::World world_;
  std::shared_ptr<grpc::Channel> channel_;
};

/// The same through the Python client in a process of its own, the columns turned into numpy arrays.
class PythonCycle {
 public:
  /// `python` runs python_client.py and speaks with the server at `address`; `scene` becomes a world there.
  PythonCycle(ChildProcess& python, const std::string& address, const Scene& scene);

  void Advance(uint32_t steps);
  Times Measure(uint32_t steps);
  client::Frame Look();

 private:
  ChildProcess& python_;
  client::World world_;
};

/// The cycle through a stream of the C++ client that has two steps in flight.
class CppDrive {
 public:
  CppDrive(const std::string& address, const Scene& scene);

  void Advance(uint32_t steps);
  /// The time from one result to the next, on average over `steps` but for those that empty the stream, after
  /// `run_in` others.
  Times Measure(uint32_t run_in, uint32_t steps);
  client::Frame Look();

 private:
  client::World world_;
  client::Drive drive_;
};

/// `steps` echoes.
Times MeasureEcho(Echo& echo, uint32_t steps);

}  // namespace genphys::bench

#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "contenders.h"
#include "echo.h"
#include "genphys/registry.h"
#include "scenes.h"
#include "support/child_process.h"
#include "support/spread.h"

namespace genphys::bench {

/// What others may use of the machine, in processors, while a round counts as undisturbed.
inline constexpr double kOthersMax = 0.1;

struct Plan {
  int rounds = 40;                // that count, of each scene
  double seconds_per_scene = 60;  // after which it ends with what it has
};

/// One scene on one engine. Durations are in microseconds, the means of each round.
struct Outcome {
  std::string engine;
  std::string scene;
  size_t rows = 0;           // of the frame
  size_t contacts = 0;       // points at the end
  size_t request_bytes = 0;  // of one cycle
  size_t reply_bytes = 0;    // of one cycle, the median
  uint64_t steps = 0;        // that each world had taken at the end
  int rounds = 0;            // that count
  int rounds_taken = 0;
  double others = 0;  // most that others used in a round that counts, in processors
  Spread in_process;
  Spread bytes_echo;
  Spread message_echo;
  Spread cpp;
  Spread drive;  // from one result to the next, two in flight
  Spread python;
  // The mean of the C++ cycles over the sum of the means of the step and of an echo, in each round.
  Spread to_bytes_echo;
  Spread to_message_echo;
  // The rate of the drive over the rate of the slower of step and echo, in each round.
  Spread drive_to_slower;
};

/// What is measured against what.
struct Parties {
  const BackendRegistry& registry;
  std::string address;  // of the server
  Echo& bytes_echo;
  Echo& message_echo;
  ChildProcess& python;
  const ChildProcess& server;
};

/// Takes the same steps of `scene` in all ways, echoes as often, some steps of each in turn, and checks that all worlds
/// come to the same state, bit by bit. Progress goes to standard error. Failures are std::runtime_errors.
Outcome Measure(const Parties& parties, const Scene& scene, const Plan& plan);

}  // namespace genphys::bench

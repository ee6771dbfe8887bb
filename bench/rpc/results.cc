#include "results.h"

#include <grpcpp/grpcpp.h>

#include <array>
#include <cstdio>
#include <sstream>
#include <utility>

#include "support/machine.h"

namespace genphys::bench {
namespace {

std::string Number(double value, int decimals) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return text.data();
}

void Write(std::ostream& out, const char* name, const Spread& spread, int decimals) {
  out << "      " << Quoted(name) << ": {\"count\": " << spread.count << ", \"p10\": " << Number(spread.p10, decimals)
      << ", \"median\": " << Number(spread.median, decimals) << ", \"p90\": " << Number(spread.p90, decimals) << "},\n";
}

void Write(std::ostream& out, const Outcome& outcome) {
  out << "    {\n      \"engine\": " << Quoted(outcome.engine) << ",\n      \"scene\": " << Quoted(outcome.scene)
      << ",\n      \"rows\": " << outcome.rows << ",\n      \"contacts\": " << outcome.contacts
      << ",\n      \"request_bytes\": " << outcome.request_bytes << ",\n      \"reply_bytes\": " << outcome.reply_bytes
      << ",\n      \"rounds\": " << outcome.rounds << ",\n      \"rounds_taken\": " << outcome.rounds_taken
      << ",\n      \"others_max_processors\": " << Number(outcome.others, 2) << ",\n";
  Write(out, "in_process_us", outcome.in_process, 2);
  Write(out, "bytes_echo_us", outcome.bytes_echo, 2);
  Write(out, "message_echo_us", outcome.message_echo, 2);
  Write(out, "cpp_cycle_us", outcome.cpp, 2);
  Write(out, "cpp_drive_us", outcome.drive, 2);
  Write(out, "python_cycle_us", outcome.python, 2);
  Write(out, "cpp_cycle_to_step_and_bytes_echo", outcome.to_bytes_echo, 4);
  Write(out, "cpp_cycle_to_step_and_message_echo", outcome.to_message_echo, 4);
  Write(out, "cpp_drive_rate_to_slower_of_step_and_bytes_echo", outcome.drive_to_slower, 4);
  out << "      \"steps\": " << outcome.steps << "\n    }";
}

void Write(std::ostream& out, const WorldsOutcome& outcome) {
  out << "    {\n      \"engine\": " << Quoted(outcome.engine) << ",\n      \"worlds\": " << outcome.worlds
      << ",\n      \"bodies_each\": " << outcome.bodies
      << ",\n      \"others_max_processors\": " << Number(outcome.others, 2) << ",\n";
  Write(out, "one_thread_in_process_us", outcome.one_thread, 1);
  Write(out, "step_worlds_us", outcome.step_worlds, 1);
  Write(out, "speedup", outcome.speedup, 3);
  out << "      \"rounds\": " << outcome.rounds << "\n    }";
}

void Write(std::ostream& out, const std::pair<std::string, Rates>& outcome) {
  const Rates& rates = outcome.second;
  out << "    {\n";
  Write(out, "cpp_forces_per_second", rates.forces_cpp, 0);
  Write(out, "python_forces_per_second", rates.forces_python, 0);
  Write(out, "entities_created_per_second", rates.creations, 0);
  Write(out, "python_frame_to_numpy_us", rates.frame_to_numpy, 2);
  Write(out, "python_small_frames_per_second", rates.small_frames, 0);
  Write(out, "unwatched_ns_per_body_and_step", rates.unwatched, 3);
  out << "      \"rows\": " << kRateRows << ",\n      \"engine\": " << Quoted(outcome.first) << "\n    }";
}

template <typename Outcomes>
void WriteAll(std::ostream& out, const char* name, const Outcomes& outcomes) {
  out << "  " << Quoted(name) << ": [\n";
  const char* separator = "";
  for (const auto& outcome : outcomes) {
    out << std::exchange(separator, ",\n");
    Write(out, outcome);
  }
  out << "\n  ]";
}

void WriteVersions(std::ostream& out, const Results& results, const BackendRegistry& registry) {
  out << "  \"versions\": {\n    \"grpc\": " << Quoted(grpc::Version()) << ",\n    ";
  WriteEngines(out, registry);
  out << ",\n    \"python_client\": " << results.python_versions << "\n  },\n";
}

}  // namespace

std::string ToJson(const Results& results, const BackendRegistry& registry) {
  std::ostringstream out;
  out << "{\n  \"benchmark\": \"rpc\",\n  \"date\": " << Quoted(results.date) << ",\n";
  WriteMachine(out);
  WriteVersions(out, results, registry);
  out << "  \"load_average_before\": " << Number(results.load_before, 2) << ",\n";
  WriteAll(out, "results", results.outcomes);
  out << ",\n";
  WriteAll(out, "worlds", results.worlds);
  out << ",\n";
  WriteAll(out, "rates", results.rates);
  out << "\n}\n";
  return out.str();
}

}  // namespace genphys::bench

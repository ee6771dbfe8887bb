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
  Write(out, "python_cycle_us", outcome.python, 2);
  Write(out, "cpp_cycle_to_step_and_bytes_echo", outcome.to_bytes_echo, 4);
  Write(out, "cpp_cycle_to_step_and_message_echo", outcome.to_message_echo, 4);
  out << "      \"steps\": " << outcome.steps << "\n    }";
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
  out << "  \"load_average_before\": " << Number(results.load_before, 2) << ",\n  \"results\": [\n";
  const char* separator = "";
  for (const Outcome& outcome : results.outcomes) {
    out << std::exchange(separator, ",\n");
    Write(out, outcome);
  }
  out << "\n  ]\n}\n";
  return out.str();
}

}  // namespace genphys::bench

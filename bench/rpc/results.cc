#include "results.h"

#include <grpcpp/grpcpp.h>
#include <sys/utsname.h>

#include <array>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <sstream>
#include <string_view>
#include <thread>
#include <utility>

namespace genphys::bench {
namespace {

std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) >= ' ') quoted += c;
  }
  return quoted + '"';
}

// The value of the first line "key<separator>value" of a file; empty if it has none.
std::string Lookup(const char* path, std::string_view key, char separator) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const size_t end = line.find(separator);
    if (end == std::string::npos || !line.starts_with(key)) continue;
    const size_t value = line.find_first_not_of(" \t\"", end + 1);
    if (value == std::string::npos) return "";
    return line.substr(value, line.find_last_not_of(" \t\"") + 1 - value);
  }
  return "";
}

bool IsVirtual() {
  return (' ' + Lookup("/proc/cpuinfo", "flags", ':') + ' ').find(" hypervisor ") != std::string::npos;
}

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

void WriteMachine(std::ostream& out) {
  utsname names{};
  uname(&names);
  out << "  \"machine\": {\n    \"processors\": " << std::thread::hardware_concurrency()
      << ",\n    \"processor\": " << Quoted(Lookup("/proc/cpuinfo", "model name", ':'))
      << ",\n    \"virtual\": " << (IsVirtual() ? "true" : "false")
      << ",\n    \"architecture\": " << Quoted(names.machine)
      << ",\n    \"system\": " << Quoted(Lookup("/etc/os-release", "PRETTY_NAME", '=')) << "\n  },\n";
}

void WriteVersions(std::ostream& out, const Results& results, const BackendRegistry& registry) {
  out << "  \"versions\": {\n    \"grpc\": " << Quoted(grpc::Version())
      << ",\n    \"compiler\": " << Quoted(__VERSION__) << ",\n    \"engines\": {";
  const char* separator = "";
  for (const auto& backend : registry.backends()) {
    out << std::exchange(separator, ", ") << Quoted(backend->capabilities().engine()) << ": "
        << Quoted(backend->capabilities().version());
  }
  out << "},\n    \"python_client\": " << results.python_versions << "\n  },\n";
}

}  // namespace

std::string Now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

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

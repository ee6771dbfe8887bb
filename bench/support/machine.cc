#include "machine.h"

#include <sys/utsname.h>

#include <array>
#include <ctime>
#include <fstream>
#include <ostream>
#include <thread>
#include <utility>

namespace genphys::bench {
namespace {

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

}  // namespace

std::string Now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) >= ' ') quoted += c;
  }
  return quoted + '"';
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

void WriteEngines(std::ostream& out, const BackendRegistry& registry) {
  out << "\"compiler\": " << Quoted(__VERSION__) << ",\n    \"engines\": {";
  const char* separator = "";
  for (const auto& backend : registry.backends()) {
    out << std::exchange(separator, ", ") << Quoted(backend->capabilities().engine()) << ": "
        << Quoted(backend->capabilities().version());
  }
  out << "}";
}

}  // namespace genphys::bench

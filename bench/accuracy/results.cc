#include "results.h"

#include <array>
#include <cstdio>
#include <sstream>
#include <utility>

#include "support/machine.h"

namespace genphys::bench {
namespace {

std::string Number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", value);
  return text.data();
}

void Write(std::ostream& out, const Problem& problem) {
  out << "    {\"id\": " << Quoted(problem.id) << ", \"title\": " << Quoted(problem.title)
      << ", \"error\": " << Quoted(problem.error) << ", \"first_order\": " << (problem.first_order ? "true" : "false")
      << ", \"euler_error\": " << (problem.euler_error ? Number(*problem.euler_error) : "null") << "}";
}

void Write(std::ostream& out, const Result& result) {
  out << "    {\"problem\": " << Quoted(result.problem) << ", \"contender\": " << Quoted(result.contender)
      << ", \"rate\": " << result.rate << ", \"cpu\": " << (result.cpu > 0 ? Number(result.cpu) : "null");
  if (!result.failure.empty()) out << ", \"failure\": " << Quoted(result.failure);
  out << ", \"quantities\": {";
  const char* separator = "";
  for (const Quantity& quantity : result.quantities) {
    out << std::exchange(separator, ", ") << Quoted(quantity.name) << ": " << Number(quantity.value);
  }
  out << "}}";
}

template <typename Items>
void WriteList(std::ostream& out, const char* name, const Items& items) {
  out << "  " << Quoted(name) << ": [\n";
  const char* separator = "";
  for (const auto& item : items) {
    out << std::exchange(separator, ",\n");
    Write(out, item);
  }
  out << "\n  ]";
}

}  // namespace

std::string ToJson(const Results& results, const std::vector<Problem>& problems, const BackendRegistry& registry) {
  std::ostringstream out;
  out << "{\n  \"benchmark\": \"accuracy\",\n  \"date\": " << Quoted(results.date) << ",\n";
  WriteMachine(out);
  out << "  \"versions\": {\n    ";
  WriteEngines(out, registry);
  out << "\n  },\n  \"calibration\": " << Number(results.calibration) << ",\n";
  WriteList(out, "problems", problems);
  out << ",\n";
  WriteList(out, "results", results.results);
  out << "\n}\n";
  return out.str();
}

}  // namespace genphys::bench

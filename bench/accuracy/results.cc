#include "results.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>
#include <utility>

#include "support/machine.h"

namespace genphys::bench {
namespace {

std::string Number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.5g", value);
  return text.data();
}

void Write(std::ostream& out, const Result& result) {
  out << "        " << Quoted(std::to_string(result.rate))
      << ": {\"cpu\": " << (result.cpu > 0 ? Number(result.cpu) : "null");
  if (!result.failure.empty()) out << ", \"failure\": " << Quoted(result.failure);
  for (const Quantity& quantity : result.quantities)
    out << ", " << Quoted(quantity.name) << ": " << Number(quantity.value);
  out << "}";
}

// By contender, then by steps per second.
void WriteResults(std::ostream& out, const std::string& problem, const std::vector<const Result*>& results) {
  std::map<std::string, std::vector<const Result*>> by_contender;
  for (const Result* result : results) {
    if (result->problem == problem) by_contender[result->contender].push_back(result);
  }
  const char* separator = "";
  for (const auto& [contender, found] : by_contender) {
    out << std::exchange(separator, ",\n") << "      " << Quoted(contender) << ": {\n";
    const char* inner = "";
    for (const Result* result : found) {
      out << std::exchange(inner, ",\n");
      Write(out, *result);
    }
    out << "\n      }";
  }
}

void Write(std::ostream& out, const Problem& problem, const std::vector<const Result*>& results) {
  out << "    {\"id\": " << Quoted(problem.id) << ", \"title\": " << Quoted(problem.title)
      << ",\n     \"error\": " << Quoted(problem.error)
      << ", \"first_order\": " << (problem.first_order ? "true" : "false")
      << ", \"euler_error\": " << (problem.euler_error ? Number(*problem.euler_error) : "null") << ", \"results\": {\n";
  WriteResults(out, problem.id, results);
  out << "\n    }}";
}

}  // namespace

std::string ToJson(const Results& results, Part part, const std::vector<Problem>& problems,
                   const BackendRegistry& registry) {
  std::vector<const Result*> mine;
  for (const Result& result : results.results) {
    if (results.peers.contains(result.contender) == (part == Part::kPeers)) mine.push_back(&result);
  }
  std::ostringstream out;
  out << "{\n  \"benchmark\": \"accuracy\",\n  \"date\": " << Quoted(results.date) << ",\n";
  WriteMachine(out);
  out << "  \"versions\": {\n    ";
  WriteEngines(out, registry);
  out << "\n  },\n  \"calibration\": " << (std::isfinite(results.calibration) ? Number(results.calibration) : "null")
      << ",\n";
  const char* separator = "";
  if (part == Part::kPeers) {
    out << "  \"peers\": {";
    for (const auto& [name, about] : results.peers) {
      out << std::exchange(separator, ",") << "\n    " << Quoted(name) << ": " << about;
    }
    out << "\n  },\n";
    separator = "";
  }
  out << "  \"problems\": [\n";
  for (const Problem& problem : problems) {
    out << std::exchange(separator, ",\n");
    Write(out, problem, mine);
  }
  out << "\n  ]\n}\n";
  return out.str();
}

}  // namespace genphys::bench

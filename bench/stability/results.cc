#include "results.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <utility>

#include "support/machine.h"

namespace genphys::bench {
namespace {

std::string Number(double value) {
  if (!std::isfinite(value)) return "null";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return text.data();
}

void Write(std::ostream& out, const Outcome& outcome) {
  out << "      {\"contender\": " << Quoted(outcome.contender) << ", \"rate\": " << outcome.rate
      << ", \"seeds\": " << outcome.seeds << ", \"passed\": " << outcome.passed;
  if (!outcome.failure.empty()) out << ", \"failure\": " << Quoted(outcome.failure);
  out << ", \"worst\": {";
  const char* separator = "";
  for (const Quantity& quantity : outcome.worst) {
    out << std::exchange(separator, ", ") << Quoted(quantity.name) << ": " << Number(quantity.value);
  }
  out << "}}";
}

void Write(std::ostream& out, const Trial& trial, const std::vector<Outcome>& outcomes) {
  out << "    {\"id\": " << Quoted(trial.id) << ", \"title\": " << Quoted(trial.title) << ", \"limits\": {";
  const char* separator = "";
  for (const Limit& limit : trial.limits) {
    out << std::exchange(separator, ", ") << Quoted(limit.quantity) << ": " << Number(limit.largest);
  }
  out << "}, \"outcomes\": [\n";
  separator = "";
  for (const Outcome& outcome : outcomes) {
    if (outcome.trial != trial.id) continue;
    out << std::exchange(separator, ",\n");
    Write(out, outcome);
  }
  out << "\n    ]}";
}

}  // namespace

std::string ToJson(const std::vector<Outcome>& outcomes, const std::vector<Trial>& trials,
                   const BackendRegistry& registry) {
  std::ostringstream out;
  out << "{\n  \"benchmark\": \"stability\",\n  \"date\": " << Quoted(Now()) << ",\n";
  WriteMachine(out);
  out << "  \"versions\": {\n    ";
  WriteEngines(out, registry);
  out << "\n  },\n  \"trials\": [\n";
  const char* separator = "";
  for (const Trial& trial : trials) {
    out << std::exchange(separator, ",\n");
    Write(out, trial, outcomes);
  }
  out << "\n  ]\n}\n";
  return out.str();
}

}  // namespace genphys::bench

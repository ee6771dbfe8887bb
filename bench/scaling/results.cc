#include "results.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <sstream>
#include <utility>

#include "support/machine.h"

namespace genphys::bench {
namespace {

std::string Number(double value) {
  if (!std::isfinite(value)) return "null";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.5g", value);
  return text.data();
}

std::string ToJson(const Spread& spread) {
  return "{\"count\": " + std::to_string(spread.count) + ", \"p10\": " + Number(spread.p10) +
         ", \"median\": " + Number(spread.median) + ", \"p90\": " + Number(spread.p90) + '}';
}

void Write(std::ostream& out, const StepStats& lanes) {
  out << ",\n          \"lanes\": {\"asleep\": " << lanes.entities_asleep
      << ", \"in_flight\": " << lanes.entities_in_flight << ", \"in_engine\": " << lanes.entities_in_engine
      << ", \"pairs\": " << lanes.pairs << ", \"contacts\": " << lanes.contacts << ", \"islands\": " << lanes.islands
      << ", \"stages_us\": {";
  const char* separator = "";
  for (const StepStats::Stage& stage : lanes.stages) {
    out << std::exchange(separator, ", ") << Quoted(stage.name) << ": "
        << Number(1e-3 * static_cast<double>(stage.nanoseconds));
  }
  out << "}}";
}

void Write(std::ostream& out, const Cost& cost) {
  out << "        {\"series\": " << Quoted(cost.series) << ", \"name\": " << Quoted(cost.name)
      << ", \"size\": " << Number(cost.size) << ", \"step_us\": " << ToJson(cost.step);
  if (cost.lanes) Write(out, *cost.lanes);
  out << '}';
}

void Write(std::ostream& out, const Figure& figure) {
  out << "        {\"name\": " << Quoted(figure.name) << ", \"unit\": " << Quoted(figure.unit)
      << ", \"value\": " << ToJson(figure.value);
  if (figure.at_most) out << ", \"at_most\": " << Number(*figure.at_most);
  if (figure.at_least) out << ", \"at_least\": " << Number(*figure.at_least);
  out << '}';
}

template <typename Values>
void WriteAll(std::ostream& out, const char* name, const Values& values) {
  out << "      " << Quoted(name) << ": [\n";
  const char* separator = "";
  for (const auto& value : values) {
    out << std::exchange(separator, ",\n");
    Write(out, value);
  }
  out << "\n      ]";
}

void Write(std::ostream& out, const Outcome& outcome, const std::vector<Case>& cases) {
  const auto known = std::ranges::find(cases, outcome.scene, &Case::id);
  out << "    {\n      \"scene\": " << Quoted(outcome.scene)
      << ",\n      \"title\": " << Quoted(known == cases.end() ? "" : known->title)
      << ",\n      \"engine\": " << Quoted(outcome.engine) << ",\n      \"rounds\": " << outcome.rounds
      << ",\n      \"rounds_taken\": " << outcome.rounds_taken
      << ",\n      \"others_max_processors\": " << Number(outcome.others) << ",\n";
  WriteAll(out, "costs", outcome.costs);
  out << ",\n";
  WriteAll(out, "figures", outcome.figures);
  out << "\n    }";
}

bool IsHeld(const Figure& figure) {
  const double value = figure.value.median;
  return std::isfinite(value) && value <= figure.at_most.value_or(value) && value >= figure.at_least.value_or(value);
}

// As printf() writes it.
[[gnu::format(printf, 2, 3)]] void Print(std::string& text, const char* format, ...) {
  std::array<char, 512> line{};
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line.data(), line.size(), format, arguments);
  va_end(arguments);
  text += line.data();
}

}  // namespace

std::string ToJson(const Results& results, const std::vector<Case>& cases, const BackendRegistry& registry) {
  std::ostringstream out;
  out << "{\n  \"benchmark\": \"scaling\",\n  \"date\": " << Quoted(results.date) << ",\n";
  WriteMachine(out);
  out << "  \"versions\": {\n    ";
  WriteEngines(out, registry);
  out << "\n  },\n  \"load_average_before\": " << Number(results.load_before) << ",\n  \"results\": [\n";
  const char* separator = "";
  for (const Outcome& outcome : results.outcomes) {
    out << std::exchange(separator, ",\n");
    Write(out, outcome, cases);
  }
  out << "\n  ]\n}\n";
  return out.str();
}

std::string ToText(const Outcome& outcome) {
  std::string text;
  Print(text, "%s on %s\n", outcome.scene.c_str(), outcome.engine.c_str());
  for (const Cost& cost : outcome.costs) {
    Print(text, "  %-44s %12.3f us", cost.name.c_str(), cost.step.median);
    if (cost.lanes) {
      Print(text, "  %u asleep, %u in flight, %u in the engine, %u pairs, %u contacts, %u islands",
            cost.lanes->entities_asleep, cost.lanes->entities_in_flight, cost.lanes->entities_in_engine,
            cost.lanes->pairs, cost.lanes->contacts, cost.lanes->islands);
    }
    text += '\n';
  }
  for (const Figure& figure : outcome.figures) {
    const bool has_bar = figure.at_most || figure.at_least;
    Print(text, "  %-6s %-60s %10.4g %s",
          !has_bar         ? ""
          : IsHeld(figure) ? "held"
                           : "MISSED",
          figure.name.c_str(), figure.value.median, figure.unit.c_str());
    if (figure.at_most) Print(text, ", at most %g", *figure.at_most);
    if (figure.at_least) Print(text, ", at least %g", *figure.at_least);
    text += '\n';
  }
  return text;
}

}  // namespace genphys::bench

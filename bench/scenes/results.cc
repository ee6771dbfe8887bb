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
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return text.data();
}

void Write(std::ostream& out, const StepStats& stats, long steps) {
  const auto mean = [steps](double sum) { return Number(sum / static_cast<double>(steps)); };
  out << ",\n           \"lanes\": {\"asleep\": " << mean(stats.entities_asleep)
      << ", \"in_flight\": " << mean(stats.entities_in_flight) << ", \"in_engine\": " << mean(stats.entities_in_engine)
      << ", \"pairs\": " << mean(stats.pairs) << ", \"contacts\": " << mean(stats.contacts)
      << ", \"islands\": " << mean(stats.islands) << ", \"stages_us\": {";
  const char* separator = "";
  for (const StepStats::Stage& stage : stats.stages) {
    out << std::exchange(separator, ", ") << Quoted(stage.name) << ": "
        << mean(1e-3 * static_cast<double>(stage.nanoseconds));
  }
  out << "}}";
}

void Write(std::ostream& out, const Cost& cost, long steps) {
  out << ", \"us\": " << Number(cost.step) << ", \"dearest\": " << Number(cost.dearest);
  if (cost.ratio > 0) {
    out << ", \"ratio\": " << Number(cost.ratio) << ", \"ratio_low\": " << Number(cost.ratio_low)
        << ", \"ratio_high\": " << Number(cost.ratio_high);
  }
  out << ", \"lost\": " << cost.sight.lost << ", \"overlap\": " << Number(cost.sight.overlap)
      << ", \"gap\": " << Number(cost.sight.gap) << ", \"speed\": " << Number(cost.sight.speed);
  if (cost.gauge) out << ", \"gauge\": " << Number(*cost.gauge);
  if (cost.stats) Write(out, *cost.stats, steps);
}

void Write(std::ostream& out, const Outcome& outcome, size_t phase, const Case& what) {
  const Span& span = outcome.spans[phase];
  const long steps = span.end - span.begin;
  out << "        {\"name\": " << Quoted(what.phases[phase].name) << ", \"steps_before\": " << span.begin
      << ", \"steps\": " << steps << ", \"contenders\": [\n";
  const char* separator = "";
  for (const Standing& standing : outcome.standings) {
    out << std::exchange(separator, ",\n") << "          {\"name\": " << Quoted(standing.contender);
    if (!standing.not_had.empty()) out << ", \"not_had\": " << Quoted(standing.not_had);
    if (!standing.failure.empty()) out << ", \"failure\": " << Quoted(standing.failure);
    if (phase < standing.costs.size()) Write(out, standing.costs[phase], steps);
    out << '}';
  }
  out << "\n        ]}";
}

void Write(std::ostream& out, const Outcome& outcome, const Case& what) {
  out << "    {\"scene\": " << Quoted(what.id) << ", \"title\": " << Quoted(what.title)
      << ", \"engine\": " << Quoted(outcome.engine) << ",\n      \"movers\": " << outcome.movers
      << ", \"others\": " << outcome.others << ", \"joints\": " << outcome.joints << ", \"rate\": " << what.rate
      << ", \"seed\": " << kSeed << ", \"rounds\": " << outcome.rounds
      << ", \"others_max_processors\": " << Number(outcome.others_used);
  if (what.gauge) out << ", \"gauge\": " << Quoted(what.gauge->name);
  out << ",\n      \"phases\": [\n";
  for (size_t phase = 0; phase < outcome.spans.size(); ++phase) {
    if (phase > 0) out << ",\n";
    Write(out, outcome, phase, what);
  }
  out << "\n      ]}";
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
  out << "{\n  \"benchmark\": \"scenes\",\n  \"date\": " << Quoted(results.date) << ",\n";
  WriteMachine(out);
  out << "  \"versions\": {\n    ";
  WriteEngines(out, registry);
  out << "\n  },\n  \"load_average_before\": " << Number(results.load_before) << ",\n  \"results\": [\n";
  const char* separator = "";
  for (const Outcome& outcome : results.outcomes) {
    out << std::exchange(separator, ",\n");
    Write(out, outcome, *std::ranges::find(cases, outcome.scene, &Case::id));
  }
  out << "\n  ]\n}\n";
  return out.str();
}

std::string ToText(const Outcome& outcome, const Case& what) {
  std::string text;
  for (size_t phase = 0; phase < outcome.spans.size(); ++phase) {
    Print(text, "%s on %s, %s: %zu bodies, %zu joints, %d rounds\n", what.id.c_str(), outcome.engine.c_str(),
          what.phases[phase].name.c_str(), outcome.movers, outcome.joints, outcome.rounds);
    for (const Standing& standing : outcome.standings) {
      Print(text, "  %-24s", standing.contender.c_str());
      if (!standing.not_had.empty()) Print(text, " has not: %s", standing.not_had.c_str());
      if (!standing.failure.empty()) Print(text, " FAILED: %s", standing.failure.c_str());
      if (phase < standing.costs.size()) {
        const Cost& cost = standing.costs[phase];
        Print(text, " %9.3f us  x %6.2f (%.2f to %.2f)  dearest x %5.2f  lost %zu  overlap %.2e  gap %.2e  speed %.2e",
              cost.step, cost.ratio, cost.ratio_low, cost.ratio_high, cost.dearest, cost.sight.lost, cost.sight.overlap,
              cost.sight.gap, cost.sight.speed);
        if (cost.gauge) Print(text, "  %s %.4g", what.gauge->name.c_str(), *cost.gauge);
      }
      text += '\n';
    }
  }
  return text;
}

}  // namespace genphys::bench

// Measures what everyday scenes cost beside the engines alone: see README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "case.h"
#include "contenders/contender.h"
#include "genphys/builtin_backends.h"
#include "measure.h"
#include "results.h"
#include "support/machine.h"
#include "support/quiet.h"

namespace genphys::bench {
namespace {

struct CommandLine {
  std::string json;
  std::vector<std::string> scenes;
  std::vector<std::string> engines;
  Plan plan;
  bool list = false;
};

std::vector<std::string> IdsOf(const std::vector<Case>& cases) {
  std::vector<std::string> ids;
  for (const Case& each : cases) ids.push_back(each.id);
  return ids;
}

void Declare(CLI::App& app, const std::vector<Case>& cases, CommandLine& line) {
  app.add_option("--json", line.json, "file to write the results to");
  app.add_option("--scene", line.scenes, "only this scene; may be repeated")
      ->allow_extra_args(false)
      ->check(CLI::IsMember(IdsOf(cases)));
  app.add_option("--engine", line.engines, "only this engine; may be repeated")
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"ode", "bullet"}));
  CLI::Option* rounds = app.add_option("--rounds", line.plan.rounds, "how often each scene is simulated")
                            ->capture_default_str()
                            ->check(CLI::Range(1, 1'000));
  CLI::Option* seconds =
      app.add_option("--seconds", line.plan.seconds, "time for each scene and engine; no round begins after it")
          ->capture_default_str()
          ->check(CLI::Range(0.0, 86'400.0));
  app.add_flag("--quick", line.plan.is_quick, "a few steps of each: figures that show that it works, and little more")
      ->excludes(rounds)
      ->excludes(seconds);
  app.add_flag("--list", line.list, "names scenes");
}

bool IsWanted(const std::vector<std::string>& wanted, const std::string& name) {
  return wanted.empty() || std::ranges::find(wanted, name) != wanted.end();
}

void List(const std::vector<Case>& cases) {
  for (const Case& each : cases) std::printf("%-10s %s\n", each.id.c_str(), each.title.c_str());
}

// The engine alone in its defaults, and then ours with each preset.
std::vector<Contender> Rivals(const BackendRegistry& registry, const std::string& engine) {
  std::vector<Contender> rivals{RawContenders(engine).front()};
  for (const Contender& contender : Contenders(registry)) {
    if (contender.name.starts_with("genphys-" + engine)) rivals.push_back(contender);
  }
  return rivals;
}

void Run(const CommandLine& line, const std::vector<Case>& cases) {
  if (line.json.empty()) throw std::runtime_error("--json is needed");
  const BackendRegistry registry = BuiltinBackends();
  Results results{.date = Now(), .load_before = LoadAverage()};
  for (const Case& each : cases) {
    for (const std::string engine : {"ode", "bullet"}) {
      if (!IsWanted(line.scenes, each.id) || !IsWanted(line.engines, engine)) continue;
      results.outcomes.push_back(
          Measure(each, Rivals(registry, engine), "genphys-" + engine + "-balanced", registry, line.plan));
      std::fprintf(stderr, "%s", ToText(results.outcomes.back(), each).c_str());
    }
  }
  std::ofstream file(line.json);
  file << ToJson(results, cases, registry) << std::flush;
  if (!file) throw std::runtime_error(line.json + " cannot be written");
}

}  // namespace
}  // namespace genphys::bench

int main(int argc, char** argv) {
  using namespace genphys::bench;  // NOLINT(google-build-using-namespace): main itself cannot be inside
  const std::vector<Case> cases = Cases();
  CommandLine line;
  CLI::App app("Measures what everyday scenes cost beside the engines alone.", "script/bench scenes");
  Declare(app, cases, line);
  CLI11_PARSE(app, argc, argv);
  if (line.list) {
    List(cases);
    return EXIT_SUCCESS;
  }
  try {
    Run(line, cases);
  } catch (const std::exception& exception) {
    std::fprintf(stderr, "bench_scenes: %s\n", exception.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}

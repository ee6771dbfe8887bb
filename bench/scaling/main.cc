// Measures what cost grows with, and what it does not: see README.md.
#include <signal.h>

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
#include "genphys/builtin_backends.h"
#include "results.h"
#include "support/machine.h"
#include "support/quiet.h"

namespace genphys::bench {
namespace {

// What --quick leaves of it: enough to see that it works.
constexpr Plan kQuick{.rounds = 5, .seconds = 5, .trials = 7, .watch_seconds = 2};

struct CommandLine {
  std::string server;
  std::string json;
  std::vector<std::string> scenes;
  std::vector<std::string> engines;
  Plan plan;
  bool quick = false;
  bool list = false;
};

std::vector<std::string> IdsOf(const std::vector<Case>& cases) {
  std::vector<std::string> ids;
  for (const Case& each : cases) ids.push_back(each.id);
  return ids;
}

void Declare(CLI::App& app, const std::vector<Case>& cases, CommandLine& line) {
  app.add_option("--server", line.server, "the program genphysd")->check(CLI::ExistingFile);
  app.add_option("--json", line.json, "file to write the results to");
  app.add_option("--scene", line.scenes, "only this scene; may be repeated")
      ->allow_extra_args(false)
      ->check(CLI::IsMember(IdsOf(cases)));
  app.add_option("--engine", line.engines, "only this engine; may be repeated")
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"ode", "bullet"}));
  CLI::Option* rounds = app.add_option("--rounds", line.plan.rounds, "undisturbed rounds of each scene")
                            ->capture_default_str()
                            ->check(CLI::Range(1, 100'000));
  CLI::Option* seconds =
      app.add_option("--seconds", line.plan.seconds,
                     "time for each scene; when it is over, the rounds count that others disturbed least")
          ->capture_default_str()
          ->check(CLI::Range(0.0, 86'400.0));
  app.add_flag("--quick", line.quick, "few rounds: figures that show that it works, and little more")
      ->excludes(rounds)
      ->excludes(seconds);
  app.add_flag("--list", line.list, "names scenes");
}

bool IsWanted(const std::vector<std::string>& wanted, const std::string& name) {
  return wanted.empty() || std::ranges::find(wanted, name) != wanted.end();
}

void List(const std::vector<Case>& cases) {
  for (const Case& each : cases) std::printf("%-8s %s\n", each.id.c_str(), each.title.c_str());
}

void Run(const CommandLine& line, const std::vector<Case>& cases) {
  if (line.server.empty() || line.json.empty()) throw std::runtime_error("--server and --json are needed");
  const BackendRegistry registry = BuiltinBackends();
  Results results{.date = Now(), .load_before = LoadAverage()};
  for (const Case& each : cases) {
    for (const char* engine : {"ode", "bullet"}) {
      if (!IsWanted(line.scenes, each.id) || !IsWanted(line.engines, engine)) continue;
      results.outcomes.push_back(each.measure({registry, engine, line.server, line.quick ? kQuick : line.plan}));
      std::fprintf(stderr, "%s\n", ToText(results.outcomes.back()).c_str());
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
  // A server that ended is told by the failing call.
  signal(SIGPIPE, SIG_IGN);
  const std::vector<Case> cases = Cases();
  CommandLine line;
  CLI::App app("Measures what a step, a world and a server cost as there is more of them.", "script/bench scaling");
  Declare(app, cases, line);
  CLI11_PARSE(app, argc, argv);
  if (line.list) {
    List(cases);
    return EXIT_SUCCESS;
  }
  try {
    Run(line, cases);
  } catch (const std::exception& exception) {
    std::fprintf(stderr, "bench_scaling: %s\n", exception.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}

// Measures what serving a step costs: see README.md.
#include <malloc.h>
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

#include "echo.h"
#include "genphys/builtin_backends.h"
#include "measure.h"
#include "results.h"
#include "scenes.h"
#include "support/child_process.h"
#include "support/machine.h"
#include "support/quiet.h"
#include "support/server_process.h"

namespace genphys::bench {
namespace {

// What is no scene of one world, under the same option.
constexpr char kWorldsScene[] = "worlds";
constexpr char kRatesScene[] = "rates";

struct CommandLine {
  std::string server;
  std::string python = "/usr/bin/python3";
  std::string python_client;
  std::string json;
  std::vector<std::string> engines;
  std::vector<std::string> scenes;
  Plan plan;
};

void Declare(CLI::App& app, CommandLine& line) {
  app.add_option("--server", line.server, "the program genphysd")->required()->check(CLI::ExistingFile);
  app.add_option("--python", line.python, "the interpreter that has grpc and numpy")->capture_default_str();
  app.add_option("--python-client", line.python_client, "python_client.py")->required()->check(CLI::ExistingFile);
  app.add_option("--json", line.json, "file to write the results to")->required();
  app.add_option("--engine", line.engines, "only this engine; may be repeated")->allow_extra_args(false);
  app.add_option("--scene", line.scenes, "only this scene: sleepers, flyers, pile, worlds or rates; may be repeated")
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"sleepers", "flyers", "pile", kWorldsScene, kRatesScene}));
  app.add_option("--rounds", line.plan.rounds, "undisturbed rounds of each scene")
      ->capture_default_str()
      ->check(CLI::Range(1, 100'000));
  app.add_option("--seconds", line.plan.seconds_per_scene,
                 "time for each scene; when it is over, the rounds count that others disturbed least")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 86'400.0));
}

bool IsWanted(const std::vector<std::string>& wanted, const std::string& name) {
  return wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end();
}

// Those that know contacts: without them there is neither rest nor a pile.
std::vector<std::string> EnginesOf(const BackendRegistry& registry, const std::vector<std::string>& wanted) {
  std::vector<std::string> engines;
  for (const auto& backend : registry.backends()) {
    const Capabilities& capabilities = backend->capabilities();
    if (capabilities.Has(Feature::kContacts) && IsWanted(wanted, capabilities.engine())) {
      engines.push_back(capabilities.engine());
    }
  }
  if (engines.empty()) throw std::runtime_error("this build has no such engine");
  return engines;
}

void Run(const CommandLine& line) {
  const BackendRegistry registry = BuiltinBackends();
  const std::vector<std::string> engines = EnginesOf(registry, line.engines);
  Results results{.date = Now(), .load_before = LoadAverage()};
  const ServerProcess server(line.server);
  ChildProcess python({line.python, line.python_client, server.address()});
  results.python_versions = python.ReadLine();
  Echo bytes_echo(Echo::Kind::kBytes);
  Echo message_echo(Echo::Kind::kMessages);
  const Parties parties{registry, server.address(), bytes_echo, message_echo, python, server.process()};
  for (const std::string& engine : engines) {
    for (const Scene& scene : Scenes(engine)) {
      if (IsWanted(line.scenes, scene.name)) results.outcomes.push_back(Measure(parties, scene, line.plan));
    }
    if (IsWanted(line.scenes, kWorldsScene)) results.worlds.push_back(MeasureWorlds(parties, engine, line.plan));
    if (IsWanted(line.scenes, kRatesScene)) results.rates.emplace_back(engine, MeasureRates(parties, engine));
  }
  std::ofstream file(line.json);
  file << ToJson(results, registry) << std::flush;
  if (!file) throw std::runtime_error(line.json + " cannot be written");
}

// Whether the last reply's memory goes back to the system, to be faulted in again for the next one, depends on what
// else happens to lie above it. That costs as much as the call, and must not decide between runs: nothing is given
// back.
void KeepMemory() {
  constexpr int kTrimBytes = 64 << 20;
  constexpr int kMapBytes = 32 << 20;
  mallopt(M_TRIM_THRESHOLD, kTrimBytes);
  mallopt(M_MMAP_THRESHOLD, kMapBytes);
}

}  // namespace
}  // namespace genphys::bench

int main(int argc, char** argv) {
  using namespace genphys::bench;  // NOLINT(google-build-using-namespace): main itself cannot be inside
  KeepMemory();
  if (argc == 3 && argv[1] == kEchoServer) return RunEchoServer(argv[2]);
  // A child that ended is told by the failing write.
  signal(SIGPIPE, SIG_IGN);
  CommandLine line;
  CLI::App app("Measures what serving a step costs, against doing it in the same process.", "script/bench rpc");
  Declare(app, line);
  CLI11_PARSE(app, argc, argv);
  try {
    Run(line);
  } catch (const std::exception& exception) {
    std::fprintf(stderr, "bench_rpc: %s\n", exception.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}

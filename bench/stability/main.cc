// Puts stress on worlds and says who stands it: see README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bars.h"
#include "contenders/contender.h"
#include "genphys/builtin_backends.h"
#include "results.h"
#include "trial.h"

namespace genphys::bench {
namespace {

struct CommandLine {
  std::string json;
  std::vector<std::string> trials;
  std::vector<std::string> contenders;
  std::vector<int> rates;
  uint32_t seeds = 0;
  bool is_long = false;
  bool frontier = false;
  bool bars = false;
  bool list = false;
};

void Declare(CLI::App& app, CommandLine& line) {
  app.add_option("--json", line.json, "file to write the results to");
  app.add_option("--trial", line.trials, "only this one and its sizes, as in S1; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--contender", line.contenders, "only those whose name has this in it; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--rate", line.rates, "only so many steps per second; may be repeated")->allow_extra_args(false);
  app.add_option("--seeds", line.seeds, "of each trial; 0: as many as it says")->check(CLI::Range(0, 1'000'000));
  app.add_flag("--long", line.is_long, "also those that take minutes");
  app.add_flag("--frontier", line.frontier,
               "our model at the settings among which presets were chosen, and nobody else");
  app.add_flag("--bars", line.bars, "only what a bar is set for; says which are held, and fails if one is not");
  app.add_flag("--list", line.list, "names trials and contenders");
}

bool IsWanted(const std::vector<std::string>& wanted, const auto& matches) {
  return wanted.empty() || std::ranges::any_of(wanted, matches);
}

// The worst of all seeds, quantity by quantity.
Outcome Take(const Trial& trial, const Contender& contender, int rate, uint32_t seeds) {
  Outcome outcome{.trial = trial.id, .contender = contender.name, .rate = rate, .seeds = seeds};
  const Lab lab(contender, 1.0 / rate, StepPlan::kEven);
  for (uint32_t seed = 1; seed <= seeds; ++seed) {
    bool passed = true;
    try {
      const std::vector<Quantity> quantities = trial.run(lab, seed);
      if (outcome.worst.empty()) outcome.worst = quantities;
      for (size_t i = 0; i < quantities.size(); ++i) {
        const double value = quantities[i].value;
        if (!(value <= outcome.worst[i].value)) outcome.worst[i].value = value;
        for (const Limit& limit : trial.limits) {
          passed = passed && (limit.quantity != quantities[i].name || value <= limit.largest);
        }
      }
    } catch (const std::exception& exception) {
      passed = false;
      outcome.failure = exception.what();
    }
    outcome.passed += passed ? 1 : 0;
  }
  return outcome;
}

void Tell(const Outcome& outcome) {
  std::fprintf(stderr, "%s  %-12s %-24s 1/%-5d %u of %u ", outcome.passed == outcome.seeds ? "pass" : "FAIL",
               outcome.trial.c_str(), outcome.contender.c_str(), outcome.rate, outcome.passed, outcome.seeds);
  for (const Quantity& quantity : outcome.worst) {
    std::fprintf(stderr, " %s %.3g", quantity.name.c_str(), quantity.value);
  }
  std::fprintf(stderr, " %s\n", outcome.failure.c_str());
}

std::vector<Outcome> TakeAll(const CommandLine& line, const std::vector<Trial>& trials,
                             const std::vector<Contender>& contenders) {
  std::set<std::pair<std::string, std::string>> barred;
  for (const Bar& bar : Bars()) barred.insert({bar.trial, bar.contender});
  std::vector<Outcome> outcomes;
  for (const Trial& trial : trials) {
    for (const int rate : trial.rates) {
      if (!line.rates.empty() && std::ranges::find(line.rates, rate) == line.rates.end()) continue;
      for (const Contender& contender : contenders) {
        if (trial.needs_springs && !contender.name.starts_with("genphys")) continue;
        if (line.bars && !barred.contains({trial.id, contender.name})) continue;
        outcomes.push_back(Take(trial, contender, rate, line.seeds == 0 ? trial.seeds : line.seeds));
        Tell(outcomes.back());
      }
    }
  }
  return outcomes;
}

int Judge(const CommandLine& line) {
  const BackendRegistry registry = BuiltinBackends();
  std::vector<Trial> trials = Trials();
  std::erase_if(trials, [&](const Trial& trial) {
    const auto named = [&](const std::string& name) { return trial.id == name || trial.id.starts_with(name + '.'); };
    return (trial.is_long && !line.is_long) || !IsWanted(line.trials, named);
  });
  std::vector<Contender> contenders = line.frontier ? FrontierContenders(registry) : Contenders(registry);
  std::erase_if(contenders, [&](const Contender& contender) {
    return !IsWanted(line.contenders,
                     [&](const std::string& name) { return contender.name.find(name) != std::string::npos; });
  });
  if (trials.empty() || contenders.empty()) throw std::runtime_error("there is no such trial or contender");
  if (line.list) {
    for (const Trial& trial : trials) std::printf("%-14s %s\n", trial.id.c_str(), trial.title.c_str());
    for (const Contender& contender : contenders) std::printf("%s\n", contender.name.c_str());
    return EXIT_SUCCESS;
  }
  const std::vector<Outcome> outcomes = TakeAll(line, trials, contenders);
  if (!line.json.empty()) {
    std::ofstream file(line.json);
    file << ToJson(outcomes, trials, registry) << std::flush;
    if (!file) throw std::runtime_error(line.json + " cannot be written");
  }
  if (!line.bars) return EXIT_SUCCESS;
  return PrintBars(outcomes) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace
}  // namespace genphys::bench

int main(int argc, char** argv) {
  using namespace genphys::bench;  // NOLINT(google-build-using-namespace): main itself cannot be inside
  CommandLine line;
  CLI::App app("Puts stress on worlds and says who stands it.", "script/bench stability");
  Declare(app, line);
  CLI11_PARSE(app, argc, argv);
  try {
    return Judge(line);
  } catch (const std::exception& exception) {
    std::fprintf(stderr, "bench_stability: %s\n", exception.what());
    return EXIT_FAILURE;
  }
}

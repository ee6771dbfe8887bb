// Measures how right and how dear steps are: see README.md.
#include <signal.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "bars.h"
#include "genphys/builtin_backends.h"
#include "measure.h"
#include "peers/peer.h"
#include "problem.h"
#include "results.h"
#include "support/machine.h"

namespace genphys::bench {
namespace {

struct CommandLine {
  std::string json;
  std::string peers_json;
  std::vector<std::string> peers;
  std::vector<std::string> problems;
  std::vector<std::string> contenders;
  std::vector<int> rates;
  int rounds = 5;
  bool frontier = false;
  bool engine_only = false;
  bool quick = false;
  bool bars = false;
  bool list = false;
};

void Declare(CLI::App& app, CommandLine& line) {
  app.add_option("--json", line.json, "file to write the results to");
  app.add_option("--peer", line.peers,
                 "another engine: its name, =, and a program that simulates with it (bench/peers); may be repeated")
      ->allow_extra_args(false);
  app.add_option("--peers-json", line.peers_json, "file to write the results of peers to");
  app.add_option("--problem", line.problems, "only this problem and its variants, as in C5; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--contender", line.contenders, "only those whose name has this in it; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--rate", line.rates, "only so many steps per second; may be repeated")->allow_extra_args(false);
  app.add_option("--rounds", line.rounds, "turns of each contender whose processor time is taken; 0: none")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000));
  app.add_flag("--frontier", line.frontier,
               "our model at the settings among which presets were chosen, and nobody else");
  app.add_flag("--engine-only", line.engine_only, "our model with every body left to the engine, to compare")
      ->excludes("--frontier");
  app.add_flag("--quick", line.quick, "60, 240 and 1000 steps per second, one round");
  app.add_flag("--bars", line.bars, "only what a bar is set for; says which are held, and fails if one is not");
  app.add_flag("--list", line.list, "names problems and contenders");
  app.footer(
      "script/bench accuracy also knows --record, which makes the results those of the tree, and --peers, which "
      "installs\n"
      "other engines and measures them too, and --lanes: see bench/accuracy/README.md.");
}

bool IsWanted(const std::vector<std::string>& wanted, const auto& matches) {
  return wanted.empty() || std::ranges::any_of(wanted, matches);
}

class Session {
 public:
  Session(const CommandLine& line, const BackendRegistry& registry)
      : line_(line),
        contenders_(line.frontier ? FrontierContenders(registry) : Contenders(registry, line.engine_only)) {
    for (const std::string& description : line.peers) Add(description);
    for (Problem& problem : Problems()) {
      const bool wanted = IsWanted(line.problems, [&](const std::string& name) {
        return problem.id == name || problem.id.starts_with(name + '.');
      });
      if (wanted) problems_.push_back(std::move(problem));
    }
    std::erase_if(contenders_, [&](const Contender& contender) {
      return !IsWanted(line.contenders,
                       [&](const std::string& name) { return contender.name.find(name) != std::string::npos; });
    });
    for (const Bar& bar : Bars()) {
      // An order is of two rates, each asked for.
      const std::vector<int> all = bar.rates.empty() ? kRates : bar.rates;
      for (const int rate : all) {
        barred_.insert({bar.problem, bar.contender, rate});
        if (bar.kind != Bar::Kind::kCost) continue;
        costly_.insert({bar.problem, bar.contender, rate});
        costly_.insert({bar.problem, bar.against, rate});
      }
    }
    if (problems_.empty() || contenders_.empty()) throw std::runtime_error("there is no such problem or contender");
  }

  void List() const {
    for (const Problem& problem : problems_) std::printf("%-16s %s\n", problem.id.c_str(), problem.title.c_str());
    for (const Contender& contender : contenders_) std::printf("%s\n", contender.name.c_str());
  }

  Results Take() {
    Results results{.date = Now(), .peers = peers_};
    for (const Problem& problem : problems_) {
      for (const int rate : problem.rates) {
        if (IsRateWanted(problem, rate)) Take(problem, rate, results);
      }
    }
    return results;
  }

  const std::vector<Problem>& problems() const { return problems_; }

 private:
  using Place = std::tuple<std::string, std::string, int>;

  // The others are measured whatever is wrong with one.
  void Add(const std::string& description) {
    try {
      Peer peer = StartPeer(description);
      peers_[peer.contender.name] = peer.about;
      contenders_.push_back(std::move(peer.contender));
    } catch (const std::exception& exception) {
      std::fprintf(stderr, "%s is left out: %s\n", description.c_str(), exception.what());
    }
  }

  bool IsRateWanted(const Problem& problem, int rate) const {
    if (!line_.rates.empty()) return std::ranges::find(line_.rates, rate) != line_.rates.end();
    const bool is_quick = rate == 60 || rate == 240 || rate == 1000;
    return !line_.quick || is_quick || problem.rates.size() == 1;
  }

  void Take(const Problem& problem, int rate, Results& results) {
    std::vector<const Contender*> chosen;
    bool is_timed = !line_.bars && line_.rounds > 0 && problem.duration > 0;
    for (const Contender& contender : contenders_) {
      if (problem.needs_springs && !contender.name.starts_with("genphys")) continue;
      if (problem.is_large && contender.name == "raw-ode-step") continue;
      const Place place{problem.id, contender.name, rate};
      if (line_.bars && !barred_.contains(place) && !costly_.contains(place)) continue;
      is_timed = is_timed || costly_.contains(place);
      chosen.push_back(&contender);
    }
    if (chosen.empty()) return;
    std::vector<Result> found;
    for (const Contender* contender : chosen) found.push_back(Solve(problem, *contender, rate));
    if (is_timed) {
      const int rounds = line_.quick ? 1 : std::max(line_.rounds, 1);
      const double calibration = Time(problem, chosen, rate, rounds, found);
      results.calibration = std::min(results.calibration, calibration);
    }
    for (const Result& result : found) Tell(result);
    results.results.insert(results.results.end(), found.begin(), found.end());
  }

  void Tell(const Result& result) const {
    std::fprintf(stderr, "%-15s %-24s 1/%-5d", result.problem.c_str(), result.contender.c_str(), result.rate);
    for (const Quantity& quantity : result.quantities) {
      std::fprintf(stderr, " %s %.3g", quantity.name.c_str(), quantity.value);
    }
    if (result.cpu > 0) std::fprintf(stderr, "  %.1f us/s", 1e6 * result.cpu);
    std::fprintf(stderr, " %s\n", result.failure.c_str());
  }

  const CommandLine& line_;
  std::vector<Problem> problems_;
  std::vector<Contender> contenders_;
  std::map<std::string, std::string> peers_;  // what each tells of itself
  std::set<Place> barred_;
  std::set<Place> costly_;
};

void WriteFile(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text << std::flush;
  if (!file) throw std::runtime_error(path + " cannot be written");
}

int Measure(const CommandLine& line) {
  const BackendRegistry registry = BuiltinBackends();
  Session session(line, registry);
  if (line.list) {
    session.List();
    return EXIT_SUCCESS;
  }
  const Results results = session.Take();
  if (!line.json.empty()) WriteFile(line.json, ToJson(results, Part::kOurs, session.problems(), registry));
  if (!line.peers_json.empty() && !results.peers.empty()) {
    WriteFile(line.peers_json, ToJson(results, Part::kPeers, session.problems(), registry));
  }
  if (!line.bars) return EXIT_SUCCESS;
  return PrintBars(results.results) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace
}  // namespace genphys::bench

int main(int argc, char** argv) {
  using namespace genphys::bench;  // NOLINT(google-build-using-namespace): main itself cannot be inside
  // A peer that ends is told by its pipe, like any other failure.
  signal(SIGPIPE, SIG_IGN);
  CommandLine line;
  CLI::App app("Measures errors against known answers, and what they cost.", "script/bench accuracy");
  Declare(app, line);
  CLI11_PARSE(app, argc, argv);
  try {
    return Measure(line);
  } catch (const std::exception& exception) {
    std::fprintf(stderr, "bench_accuracy: %s\n", exception.what());
    return EXIT_FAILURE;
  }
}

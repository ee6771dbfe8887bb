#include "turns.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "contenders/clock.h"
#include "support/quiet.h"

namespace genphys::bench {
namespace {

using Clock = std::chrono::steady_clock;

// A turn is long enough for what happens only now and then, as when a body leaves the neighbourhood in which it was
// last seen, and short enough that whatever disturbs the machine disturbs all of them. Of cheap steps it has so many
// that reading the clock of processor time, a call of the kernel, is no part of them.
constexpr double kTurnSeconds = 20e-3;
constexpr uint32_t kStepsMin = 3;
constexpr uint32_t kStepsMax = 2'000;

// Knows how many steps make a turn.
class Runner {
 public:
  explicit Runner(const Party& party) : party_(party) {
    constexpr double kEstimateSeconds = 1e-3;
    Run(1);
    uint32_t steps = 1;
    double seconds = Run(steps);
    while (seconds < kEstimateSeconds && steps < kStepsMax) {
      steps = std::min(2 * steps, kStepsMax);
      seconds = Run(steps);
    }
    steps_ = static_cast<uint32_t>(std::clamp(kTurnSeconds * steps / seconds, double{kStepsMin}, double{kStepsMax}));
  }

  /// us per step.
  double Turn() {
    // The first ones find the caches as another party left them.
    const uint32_t warm_up = 1 + steps_ / 4;
    if (party_.prepare) party_.prepare(warm_up + steps_);
    Time(warm_up);
    return 1e6 * Time(steps_) / steps_;
  }

 private:
  double Run(uint32_t steps) {
    if (party_.prepare) party_.prepare(steps);
    return Time(steps);
  }

  // Seconds of processor time.
  double Time(uint32_t steps) {
    const double begin = ProcessorTime();
    for (uint32_t i = 0; i < steps; ++i) party_.step();
    return ProcessorTime() - begin;
  }

  const Party& party_;
  uint32_t steps_ = 1;
};

struct Round {
  std::vector<double> costs;  // by party
  double others = 0;
};

// One step may be disturbed by whatever the machine does: the quickest of some tells most.
StepStats Explain(const Party& party) {
  constexpr int kSteps = 5;
  const auto total = [](const StepStats& stats) {
    uint64_t sum = 0;
    for (const StepStats::Stage& stage : stats.stages) sum += stage.nanoseconds;
    return sum;
  };
  StepStats best;
  for (int i = 0; i < kSteps; ++i) {
    if (party.prepare) party.prepare(1);
    const StepStats stats = party.explain();
    if (i == 0 || total(stats) < total(best)) best = stats;
  }
  return best;
}

// None is always the one that comes after the same other.
Round TakeRound(std::vector<Runner>& runners, size_t first, OthersWatch& others) {
  Round round{.costs = std::vector<double>(runners.size())};
  others.Begin();
  for (size_t i = 0; i < runners.size(); ++i) {
    const size_t place = (first + i) % runners.size();
    round.costs[place] = runners[place].Turn();
  }
  round.others = others.End();
  return round;
}

}  // namespace

size_t PlaceOf(const std::vector<Party>& parties, const std::string& name) {
  const auto party = std::find_if(parties.begin(), parties.end(), [&](const Party& each) { return each.name == name; });
  if (party == parties.end()) throw std::logic_error("no party is called " + name);
  return static_cast<size_t>(party - parties.begin());
}

std::vector<double> Race::Ratios(size_t of, size_t to) const {
  std::vector<double> ratios;
  for (size_t i = 0; i < costs[of].size(); ++i) ratios.push_back(costs[of][i] / costs[to][i]);
  return ratios;
}

Race TakeTurns(const std::vector<Party>& parties, const Plan& plan, const std::string& title) {
  const Clock::time_point end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(plan.seconds));
  std::vector<Runner> runners(parties.begin(), parties.end());
  OthersWatch others({});
  TakeRound(runners, 0, others);
  std::vector<Round> rounds;
  const auto wanted = static_cast<size_t>(plan.rounds);
  int undisturbed = 0;
  for (bool is_last = false; !is_last;) {
    rounds.push_back(TakeRound(runners, rounds.size(), others));
    if (rounds.back().others <= kOthersMax) ++undisturbed;
    is_last = undisturbed >= plan.rounds || (rounds.size() >= wanted && Clock::now() >= end);
    // A line that overwrites itself is for people alone.
    if (isatty(STDERR_FILENO) == 0 && !is_last) continue;
    std::fprintf(stderr, "\r%s: %4zu rounds, %3d of %d undisturbed%s", title.c_str(), rounds.size(), undisturbed,
                 plan.rounds, is_last ? "\n" : "");
  }
  Race race{.costs = std::vector<std::vector<double>>(parties.size()), .rounds_taken = static_cast<int>(rounds.size())};
  std::sort(rounds.begin(), rounds.end(), [](const Round& a, const Round& b) { return a.others < b.others; });
  rounds.resize(std::min(rounds.size(), wanted));
  race.others = rounds.back().others;
  for (const Round& round : rounds) {
    for (size_t i = 0; i < parties.size(); ++i) race.costs[i].push_back(round.costs[i]);
  }
  return race;
}

Outcome Describe(const std::string& scene, const std::string& engine, const std::vector<Party>& parties,
                 const Race& race) {
  Outcome outcome{.scene = scene,
                  .engine = engine,
                  .rounds = static_cast<int>(race.costs.front().size()),
                  .rounds_taken = race.rounds_taken,
                  .others = race.others};
  for (size_t i = 0; i < parties.size(); ++i) {
    const Party& party = parties[i];
    Cost& cost = outcome.costs.emplace_back();
    cost = {.series = party.series, .name = party.name, .size = party.size, .step = SpreadOf(race.costs[i])};
    if (party.explain) cost.lanes = Explain(party);
  }
  return outcome;
}

}  // namespace genphys::bench

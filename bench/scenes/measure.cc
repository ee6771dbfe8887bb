#include "measure.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "contenders/clock.h"
#include "support/quiet.h"
#include "support/spread.h"

namespace genphys::bench {
namespace {

using Clock = std::chrono::steady_clock;

// A turn of one contender. Its first step finds the caches as another one left them and does not count. Rounds have
// their turns begin at different steps, so that each step but the first of a phase counts in some of them.
constexpr long kTurn = 16;
constexpr long kTurnShift = 5;
constexpr double kDoesNotCount = std::numeric_limits<double>::quiet_NaN();

std::vector<Span> SpansOf(const Case& what, bool is_quick) {
  constexpr long kQuickBefore = 5, kQuickSteps = 10;
  std::vector<Span> spans;
  long past = 0;
  for (const Phase& phase : what.phases) {
    long begin = std::lround(phase.begin * what.rate), count = std::lround(phase.seconds * what.rate);
    if (is_quick) begin = past + std::min(begin - past, kQuickBefore), count = std::min(count, kQuickSteps);
    if (begin < past || count < 1) throw std::logic_error("phases come one after the other");
    spans.push_back({begin, begin + count});
    past = begin + count;
  }
  return spans;
}

// One contender on its way.
struct Runner {
  const Contender* contender = nullptr;
  Standing* standing = nullptr;
  std::unique_ptr<Simulation> simulation;
  std::vector<std::vector<std::vector<double>>> costs;  // us of a step, by phase, step and round

  bool is_in() const { return standing->not_had.empty() && standing->failure.empty(); }
};

class Race {
 public:
  Race(const Case& what, const std::vector<Contender>& contenders, const BackendRegistry& registry, const Plan& plan)
      : what_(what),
        scene_(what.make()),
        observer_(registry, scene_, what.lowest),
        rounds_(plan.is_quick ? 1 : plan.rounds),
        seconds_(plan.seconds),
        spans_(SpansOf(what, plan.is_quick)) {
    outcome_ = {.scene = what.id, .engine = contenders.at(0).engine, .joints = scene_.joints.size(), .spans = spans_};
    for (const EntityDesc& body : scene_.bodies) ++(IsDynamic(body) ? outcome_.movers : outcome_.others);
    outcome_.standings.resize(contenders.size());
    for (size_t i = 0; i < contenders.size(); ++i) {
      Standing& standing = outcome_.standings[i];
      standing.contender = contenders[i].name;
      standing.costs.resize(spans_.size());
      Runner& runner = runners_.emplace_back();
      runner.contender = &contenders[i];
      runner.standing = &standing;
      for (const Span& span : spans_) runner.costs.emplace_back(static_cast<size_t>(span.end - span.begin));
    }
  }

  Outcome Run(const std::string& explained) {
    const Clock::time_point begin = Clock::now();
    OthersWatch others({});
    do {
      std::fprintf(stderr, "%s on %s: round %d of %d\n", what_.id.c_str(), outcome_.engine.c_str(), outcome_.rounds + 1,
                   rounds_);
      others.Begin();
      TakeRound();
      outcome_.others_used = std::max(outcome_.others_used, others.End());
      ++outcome_.rounds;
    } while (outcome_.rounds < rounds_ && std::chrono::duration<double>(Clock::now() - begin).count() < seconds_);
    for (Runner& runner : runners_) {
      if (runner.is_in() && runner.contender->name == explained) Try(runner, [&] { Explain(runner); });
    }
    for (Runner& runner : runners_) Sum(runner);
    return std::move(outcome_);
  }

 private:
  template <typename Work>
  void Try(Runner& runner, const Work& work) {
    try {
      work();
    } catch (const NotHad& not_had) {
      runner.standing->not_had = not_had.what();
    } catch (const std::runtime_error& error) {
      runner.standing->failure = error.what();
    }
  }

  double TimeOf(long step) const { return static_cast<double>(step) / what_.rate; }

  void Step(Simulation& simulation, long step) const {
    if (what_.drive) what_.drive(simulation, TimeOf(step));
    simulation.Step(1.0 / what_.rate);
  }

  void TakeRound() {
    for (Runner& runner : runners_) {
      if (runner.is_in()) Try(runner, [&] { runner.simulation = runner.contender->start(scene_); });
    }
    long past = 0;
    for (size_t phase = 0; phase < spans_.size(); ++phase) {
      const Span& span = spans_[phase];
      for (Runner& runner : runners_) {
        if (!runner.is_in()) continue;
        Try(runner, [&] {
          for (long step = past; step < span.begin; ++step) Step(*runner.simulation, step);
        });
      }
      long turn = kTurn - kTurnShift * outcome_.rounds % kTurn;
      size_t first = static_cast<size_t>(outcome_.rounds);
      for (long step = span.begin; step < span.end; step += std::exchange(turn, kTurn), ++first) {
        const Span steps{step, std::min(step + turn, span.end)};
        // None is always the one that comes after the same other.
        for (size_t i = 0; i < runners_.size(); ++i) TakeTurn(runners_[(first + i) % runners_.size()], phase, steps);
      }
      past = span.end;
      if (outcome_.rounds == 0) LookAtAll(phase, past);
    }
    for (Runner& runner : runners_) runner.simulation.reset();
  }

  void TakeTurn(Runner& runner, size_t phase, const Span& steps) {
    if (!runner.is_in()) return;
    Try(runner, [&] {
      for (long step = steps.begin; step < steps.end; ++step) {
        const double begin = ProcessorTime();
        Step(*runner.simulation, step);
        const double spent = 1e6 * (ProcessorTime() - begin);
        const auto place = static_cast<size_t>(step - spans_[phase].begin);
        runner.costs[phase][place].push_back(step == steps.begin ? kDoesNotCount : spent);
      }
    });
  }

  void LookAtAll(size_t phase, long step) {
    for (Runner& runner : runners_) {
      if (!runner.is_in()) continue;
      Cost& cost = runner.standing->costs[phase];
      cost.sight = observer_.Look(*runner.simulation);
      if (what_.gauge && cost.sight.lost == 0) {
        cost.gauge = what_.gauge->read(*runner.simulation, scene_, TimeOf(step));
      }
    }
  }

  // Once more from the begin, with a look into each step.
  void Explain(Runner& runner) {
    const std::unique_ptr<Simulation> simulation = runner.contender->start(scene_);
    long step = 0;
    for (size_t phase = 0; phase < spans_.size(); ++phase) {
      for (; step < spans_[phase].begin; ++step) Step(*simulation, step);
      StepStats& sum = runner.standing->costs[phase].stats.emplace();
      for (; step < spans_[phase].end; ++step) {
        if (what_.drive) what_.drive(*simulation, TimeOf(step));
        AddTo(sum, simulation->Explain(1.0 / what_.rate));
      }
    }
  }

  static void AddTo(StepStats& sum, const StepStats& stats) {
    sum.entities_asleep += stats.entities_asleep;
    sum.entities_in_flight += stats.entities_in_flight;
    sum.entities_in_engine += stats.entities_in_engine;
    sum.pairs += stats.pairs;
    sum.contacts += stats.contacts;
    sum.islands += stats.islands;
    for (const StepStats::Stage& stage : stats.stages) {
      const auto same = std::ranges::find(sum.stages, stage.name, &StepStats::Stage::name);
      if (same == sum.stages.end()) {
        sum.stages.push_back(stage);
      } else {
        same->nanoseconds += stage.nanoseconds;
      }
    }
  }

  // us of all steps of a phase that count in one round: they are the same ones for all contenders.
  static double SumOf(const std::vector<std::vector<double>>& steps, size_t round) {
    return std::accumulate(steps.begin(), steps.end(), 0.0, [&](double sum, const std::vector<double>& costs) {
      return std::isnan(costs[round]) ? sum : sum + costs[round];
    });
  }

  void Sum(Runner& runner) {
    if (!runner.is_in()) {
      runner.standing->costs.clear();
      return;
    }
    for (size_t phase = 0; phase < spans_.size(); ++phase) {
      Cost& cost = runner.standing->costs[phase];
      const double mean = MeanStep(runner.costs[phase], cost.dearest);
      cost.step = mean / static_cast<double>(std::max<size_t>(outcome_.movers, 1));
      const Runner& base = runners_.front();
      if (!base.is_in()) continue;
      std::vector<double> ratios;
      for (size_t round = 0; round < static_cast<size_t>(outcome_.rounds); ++round) {
        ratios.push_back(SumOf(runner.costs[phase], round) / SumOf(base.costs[phase], round));
      }
      cost.ratio = Median(ratios);
      cost.ratio_low = *std::ranges::min_element(ratios);
      cost.ratio_high = *std::ranges::max_element(ratios);
    }
  }

  // us, where each step counts with the median of its rounds: whatever disturbed one of them is not in it.
  static double MeanStep(const std::vector<std::vector<double>>& steps, double& dearest) {
    std::vector<double> medians;
    for (std::vector<double> costs : steps) {
      std::erase_if(costs, [](double cost) { return std::isnan(cost); });
      if (!costs.empty()) medians.push_back(Median(costs));
    }
    const double mean = Mean(medians);
    std::sort(medians.begin(), medians.end());
    dearest = medians[static_cast<size_t>(0.99 * static_cast<double>(medians.size() - 1) + 0.5)] / mean;
    return mean;
  }

  const Case& what_;
  const Scene scene_;
  const Observer observer_;
  const int rounds_;
  const double seconds_;
  const std::vector<Span> spans_;
  std::vector<Runner> runners_;
  Outcome outcome_;
};

}  // namespace

Outcome Measure(const Case& what, const std::vector<Contender>& contenders, const std::string& explained,
                const BackendRegistry& registry, const Plan& plan) {
  return Race(what, contenders, registry, plan).Run(explained);
}

}  // namespace genphys::bench

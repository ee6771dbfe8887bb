#include "measure.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>

#include "contenders/clock.h"

namespace genphys::bench {
namespace {

// A turn takes at least this long, by runs from the start as many as it takes: what is shorter than a few ticks of the
// machine's clocks and interrupts says nothing.
constexpr double kTurnSeconds = 0.004;
constexpr int kRunsMax = 200;

class Stopwatch {
 public:
  Stopwatch(const Problem& problem, const Contender& contender, int rate)
      : problem_(problem),
        contender_(contender),
        step_(1.0 / rate),
        settling_(std::lround(problem.settle * rate)),
        steps_(std::lround(problem.duration * rate)) {}

  /// Processor time of a simulated second.
  double Turn() {
    double spent = 0;
    int runs = 0;
    while (runs < kRunsMax && spent < kTurnSeconds) {
      // What had to settle stays as it is, and the next turn goes on from there.
      if (!simulation_ || settling_ == 0) Start();
      spent += simulation_->TimedSteps(step_, steps_);
      ++runs;
    }
    return spent / (runs * problem_.duration);
  }

 private:
  void Start() {
    // Some can have one at a time only.
    simulation_.reset();
    simulation_ = contender_.start(problem_.scene);
    for (long i = 0; i < settling_; ++i) simulation_->Step(step_);
  }

  const Problem& problem_;
  const Contender& contender_;
  double step_;
  long settling_;
  long steps_;
  std::unique_ptr<Simulation> simulation_;
};

}  // namespace

Result Solve(const Problem& problem, const Contender& contender, int rate) {
  Result result{.problem = problem.id, .contender = contender.name, .rate = rate};
  if (!problem.measure) return result;
  try {
    result.quantities = problem.measure(Lab(contender, 1.0 / rate, problem.plan));
  } catch (const std::exception& exception) {
    result.failure = exception.what();
    return result;
  }
  for (const Quantity& quantity : result.quantities) {
    if (!std::isfinite(quantity.value)) result.failure = quantity.name + " is no number";
  }
  if (!result.failure.empty()) result.quantities.clear();
  return result;
}

double Time(const Problem& problem, const std::vector<const Contender*>& contenders, int rate, int rounds,
            std::vector<Result>& results) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  double calibration = kNever;
  std::vector<double> least(contenders.size(), kNever);
  std::vector<Stopwatch> watches;
  for (const Contender* contender : contenders) watches.emplace_back(problem, *contender, rate);
  for (int round = 0; round < rounds; ++round) {
    calibration = std::min(calibration, CalibrationTime());
    for (size_t i = 0; i < contenders.size(); ++i) {
      // None is always the one that comes after the same other.
      const size_t turn = (i + static_cast<size_t>(round)) % contenders.size();
      if (!results[turn].failure.empty()) continue;
      try {
        least[turn] = std::min(least[turn], watches[turn].Turn());
      } catch (const std::exception& exception) {
        results[turn].failure = exception.what();
      }
    }
  }
  for (size_t i = 0; i < contenders.size(); ++i) {
    if (least[i] < kNever) results[i].cpu = least[i];
  }
  return calibration;
}

std::optional<double> Find(const Result& result, const std::string& quantity) {
  for (const Quantity& each : result.quantities) {
    if (each.name == quantity) return each.value;
  }
  return std::nullopt;
}

}  // namespace genphys::bench

// What happens apart costs apart: islands that move, among others that rest.
#include <array>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "case.h"
#include "contenders/pile.h"
#include "local_world.h"

namespace genphys::bench {
namespace {

constexpr std::array<size_t, 6> kAwake{1, 2, 4, 8, 16, 32};
constexpr size_t kIdle = 200;
constexpr PileOptions kIsland{.row = 2, .layers = 5};
// A world that was just made knows nothing yet of the pushes between its bodies. On Bullet its solver sweeps for twice
// as long during the first hundred steps; small worlds take more steps in a turn and have them behind them sooner.
constexpr int kStepsBefore = 240;
// Bars: cost is proportional to the islands that move, and those that rest change nothing of that.
constexpr double kFitMin = 0.99;
constexpr double kSlopeChangeMax = 0.05;

struct Line {
  double slope = 0;
  double fit = 0;  // R^2
};

// By least squares.
Line LineThrough(const std::vector<double>& x, const std::vector<double>& y) {
  const auto count = static_cast<double>(x.size());
  double mean_x = 0, mean_y = 0;
  for (size_t i = 0; i < x.size(); ++i) mean_x += x[i] / count, mean_y += y[i] / count;
  double xx = 0, xy = 0, yy = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
    yy += (y[i] - mean_y) * (y[i] - mean_y);
  }
  return {xy / xx, xy * xy / (xx * yy)};
}

// `count` copies of the island in rows of 20 from the `first_row` on.
std::vector<EntityDesc> Copies(const std::vector<EntityDesc>& island, size_t count, size_t first_row, bool may_sleep) {
  constexpr double kSpacing = 16;  // m: a pile of ODE spreads over some
  constexpr size_t kRow = 20;
  std::vector<EntityDesc> bodies;
  for (size_t i = 0; i < count; ++i) {
    const Vector3 shift =
        kSpacing * Vector3(static_cast<double>(i % kRow), static_cast<double>(first_row + i / kRow), 0);
    for (EntityDesc body : island) {
      body.pose.position += shift;
      body.rigid_body->auto_disable.enabled = may_sleep;
      bodies.push_back(body);
    }
  }
  return bodies;
}

class Archipelago {
 public:
  explicit Archipelago(const Bench& bench)
      : bench_(bench), island_(Settled(bench.registry, bench.engine, PileOf(kIsland))) {
    for (const size_t idle : {size_t{0}, kIdle}) {
      for (const size_t awake : kAwake) Add(awake, idle);
    }
  }

  Outcome Measure() {
    const Race race = TakeTurns(parties_, bench_.plan, bench_.engine + " islands");
    CheckIdle();
    Outcome outcome = Describe("islands", bench_.engine, parties_, race);
    std::vector<double> ratios;
    for (size_t i = 0; i < race.costs.front().size(); ++i) {
      const auto slope_from = [&](size_t first) {
        return LineOf(first, [&](size_t place) { return race.costs[place][i]; }).slope;
      };
      ratios.push_back(slope_from(kAwake.size()) / slope_from(0));
    }
    const auto fit_from = [&](size_t first) {
      return Once(LineOf(first, [&](size_t place) { return outcome.costs[place].step.median; }).fit);
    };
    outcome.figures = {{.name = "R² of a line, alone", .value = fit_from(0), .at_least = kFitMin},
                       {.name = "R² of a line, among idle ones", .value = fit_from(kAwake.size()), .at_least = kFitMin},
                       {.name = "slope among idle ones / alone",
                        .value = SpreadOf(ratios),
                        .at_most = 1 + kSlopeChangeMax,
                        .at_least = 1 - kSlopeChangeMax}};
    return outcome;
  }

 private:
  void Add(size_t awake, size_t idle) {
    const std::string series = idle == 0 ? "alone" : "among " + WithCommas(idle) + " idle";
    const std::string name = WithCommas(awake) + " awake, " + series;
    std::fprintf(stderr, "%s islands: %s\n", bench_.engine.c_str(), name.c_str());
    constexpr size_t kRowsAwake = 2;
    LocalWorld& local = *locals_.emplace_back(std::make_unique<LocalWorld>(
        bench_.registry, WorldDesc{.engine = bench_.engine}, Copies(island_, idle, kRowsAwake, true)));
    idle_.push_back(idle * island_.size());
    // Before the others come, which then settle as they do where they are alone.
    local.AwaitSleep(idle_.back());
    for (const EntityDesc& body : Copies(island_, awake, 0, false)) local.Add(body);
    for (int i = 0; i < kStepsBefore; ++i) local.Step();
    local.world().TakeEvents();
    parties_.push_back({.series = series,
                        .name = name,
                        .size = static_cast<double>(awake),
                        .step = [&local] { local.Step(); },
                        .prepare = [&local](uint32_t) { local.world().TakeEvents(); },
                        .explain = [&local] { return local.Explain(); }});
  }

  void CheckIdle() const {
    for (size_t i = 0; i < locals_.size(); ++i) {
      if (locals_[i]->asleep() != idle_[i]) throw std::runtime_error("an idle island woke");
    }
  }

  // Through the values that `cost` has for a party, from the `first` on one for each number of islands.
  template <typename CostOf>
  Line LineOf(size_t first, CostOf cost) const {
    std::vector<double> x, y;
    for (size_t i = 0; i < kAwake.size(); ++i) {
      x.push_back(static_cast<double>(kAwake[i]));
      y.push_back(cost(first + i));
    }
    return LineThrough(x, y);
  }

  const Bench& bench_;
  const std::vector<EntityDesc> island_;
  std::vector<std::unique_ptr<LocalWorld>> locals_;
  std::vector<size_t> idle_;  // boxes that sleep, by world
  std::vector<Party> parties_;
};

}  // namespace

Outcome MeasureIslands(const Bench& bench) { return Archipelago(bench).Measure(); }

}  // namespace genphys::bench

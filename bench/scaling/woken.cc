// What it costs that a sleeping pile wakes, and one of many who sleep.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <variant>

#include "case.h"
#include "contenders/clock.h"
#include "contenders/dice.h"
#include "contenders/pile.h"
#include "genphys/client/client.h"
#include "local_world.h"
#include "support/quiet.h"

namespace genphys::bench {
namespace {

constexpr PileOptions kPile{.row = 5, .layers = 4};  // of 100 boxes
constexpr int kRowOfMany = 100;                      // boxes, of as many rows
constexpr double kGap = 1;                           // m, between them
// Bar: the step of contact may cost so many times a later one.
constexpr double kRatioMax = 2;
// Later steps that it is compared with: as many as come before anybody may sleep again.
constexpr int kStepsAfter = 20;
// Steps in which it must have come.
constexpr int kFlightMax = 60;

struct Trial {
  double before = 0;   // us of processor time, median: all sleep and something comes
  double contact = 0;  // us
  double next = 0;     // us, of the step after it
  double after = 0;    // us, median of that and later ones
  size_t woken = 0;
  double others = 0;  // processors
};

// From any side, at the height of the upper layers.
EntityDesc BallAt(const Vector3& target, Dice& dice) {
  constexpr double kDistance = 8;  // m, from the middle: outside of the pile
  constexpr double kSpeed = 20;    // m/s
  constexpr double kLift = 2;      // m/s: about what it falls by on its way
  const double angle = std::numbers::pi * dice.Next();
  const Vector3 way(std::cos(angle), std::sin(angle), 0);
  return client::Body(
      Sphere{.radius = 0.3},
      {.position = target - kDistance * way, .mass = 2, .linear_velocity = kSpeed * way + Vector3(0, 0, kLift)});
}

// From above, onto its middle.
EntityDesc BallOnto(const EntityDesc& box) {
  return client::Body(
      Sphere{.radius = 0.3},
      {.position = box.pose.position + Vector3(0, 0, 4), .mass = 1, .linear_velocity = Vector3(0, 0, -10)});
}

// From the side, over the floor, a little off its middle: what comes along a row of them, and leaves it.
EntityDesc BoxAgainst(const EntityDesc& box) {
  constexpr double kHalf = 0.3;
  EntityDesc pusher = BoxOf(box.pose.position, Vector3::Constant(kHalf));
  pusher.pose.position += Vector3(-0.95, 0.1, kHalf - box.pose.position.z());
  pusher.rigid_body->linear_velocity = {3, 0, 0};
  return pusher;
}

// Boxes that stand on the floor and touch nobody else.
std::vector<EntityDesc> ManyBoxes() {
  std::vector<EntityDesc> boxes;
  for (int i = 0; i < kRowOfMany * kRowOfMany; ++i) {
    boxes.push_back(BoxOf({(1 + kGap) * (i % kRowOfMany), (1 + kGap) * (i / kRowOfMany), 0.5}));
  }
  return boxes;
}

Vector3 MiddleOf(const std::vector<EntityDesc>& bodies) {
  Vector3 sum = Vector3::Zero();
  for (const EntityDesc& body : bodies) sum += body.pose.position;
  return sum / static_cast<double>(bodies.size());
}

class Hit {
 public:
  Hit(const Bench& bench, const std::vector<EntityDesc>& pile)
      : local_(bench.registry, {.engine = bench.engine}, pile), boxes_(pile.size()) {
    local_.AwaitSleep(boxes_);
  }

  Trial Take(const EntityDesc& thrown) {
    Trial trial;
    others_.Begin();
    thrown_ = local_.Add(thrown);
    local_.world().TakeEvents();
    std::vector<double> before, after;
    while (local_.asleep() == boxes_) {
      if (before.size() > kFlightMax) throw std::runtime_error("nobody was hit");
      before.push_back(TimedStep());
    }
    // The last one was the step of contact.
    trial.contact = before.back();
    before.pop_back();
    trial.woken = CheckWoken();
    for (int i = 0; i < kStepsAfter; ++i) after.push_back(TimedStep());
    if (local_.asleep() > boxes_ - trial.woken)
      throw std::runtime_error("the pile sleeps again before it was measured");
    trial.before = Median(before);
    trial.next = after.front();
    trial.after = Median(after);
    trial.others = others_.End();
    return trial;
  }

  StepStats Explain() { return local_.Explain(); }

  // All as before, but for where they are.
  void Rest() {
    local_.Apply(DeleteEntity{thrown_});
    local_.AwaitSleep(boxes_);
  }

 private:
  double TimedStep() {
    const double begin = ProcessorTime();
    local_.Step();
    return 1e6 * (ProcessorTime() - begin);
  }

  // In the step in which they woke what came has touched one of them, and whom it touched is awake.
  size_t CheckWoken() {
    const World& world = local_.world();
    bool has_touched = false;
    for (const Event& event : local_.world().TakeEvents()) {
      const auto* began = std::get_if<ContactBegan>(&event.kind);
      if (began == nullptr || (began->pair.a != thrown_ && began->pair.b != thrown_)) continue;
      const EntityId other = began->pair.a == thrown_ ? began->pair.b : began->pair.a;
      if (std::ranges::find(local_.ids(), other) == local_.ids().end()) continue;  // the floor
      if (event.step != world.layer_state().step) throw std::runtime_error("somebody was touched before anybody woke");
      if (world.state().asleep[other.index()]) throw std::runtime_error("who was touched sleeps through it");
      has_touched = true;
    }
    if (!has_touched) throw std::runtime_error("they woke before they were touched");
    return boxes_ - local_.asleep();
  }

  LocalWorld local_;
  size_t boxes_;
  EntityId thrown_;
  OthersWatch others_{{}};
};

template <typename Value>
std::vector<double> Each(const std::vector<Trial>& trials, Value value) {
  std::vector<double> values;
  for (const Trial& trial : trials) values.push_back(value(trial));
  return values;
}

std::vector<double> RatiosOf(const std::vector<Trial>& trials) {
  return Each(trials, [](const Trial& trial) { return trial.contact / trial.after; });
}

std::vector<double> DearerRatiosOf(const std::vector<Trial>& trials) {
  return Each(trials, [](const Trial& trial) { return std::max(trial.contact, trial.next) / trial.after; });
}

struct Trials {
  std::vector<Trial> all;
  StepStats lanes;  // after the last one
};

Trials HitPiles(const Bench& bench) {
  const std::vector<EntityDesc> pile = Settled(bench.registry, bench.engine, PileOf(kPile));
  Dice dice(1);
  Trials trials;
  for (int i = 0; i < bench.plan.trials; ++i) {
    Hit hit(bench, pile);
    trials.all.push_back(hit.Take(BallAt(MiddleOf(pile), dice)));
    trials.lanes = hit.Explain();
  }
  return trials;
}

// A stride that is prime to their number, so that each hit is elsewhere.
Trials HitOnesOfMany(const Bench& bench, EntityDesc (*thrown)(const EntityDesc& box)) {
  constexpr size_t kStride = 3571;
  const std::vector<EntityDesc> boxes = ManyBoxes();
  Hit hit(bench, boxes);
  Trials trials;
  for (size_t i = 0; i < static_cast<size_t>(bench.plan.trials); ++i) {
    trials.all.push_back(hit.Take(thrown(boxes[kStride * (i + 1) % boxes.size()])));
    trials.lanes = hit.Explain();
    hit.Rest();
  }
  return trials;
}

void AddTo(Outcome& outcome, const std::string& series, size_t bodies, const Trials& trials) {
  const auto cost = [&](const std::string& name, double Trial::*part) {
    return Cost{.series = name + series,
                .name = name + series,
                .size = static_cast<double>(bodies),
                .step = SpreadOf(Each(trials.all, [part](const Trial& trial) { return trial.*part; }))};
  };
  outcome.costs.push_back(cost("asleep, something comes", &Trial::before));
  outcome.costs.push_back(cost("step of contact", &Trial::contact));
  outcome.costs.push_back(cost("later steps", &Trial::after));
  outcome.costs.back().lanes = trials.lanes;
  const Spread woken = SpreadOf(Each(trials.all, [](const Trial& trial) { return static_cast<double>(trial.woken); }));
  std::fprintf(stderr, "%s woken%s: %zu trials, %.0f of %zu boxes woke\n", outcome.engine.c_str(), series.c_str(),
               trials.all.size(), woken.median, bodies);
  outcome.figures.push_back({.name = "step of contact / later steps" + series,
                             .value = SpreadOf(RatiosOf(trials.all)),
                             .at_most = kRatioMax});
  outcome.figures.push_back({.name = "dearer one of that step and the next / later steps" + series,
                             .value = SpreadOf(DearerRatiosOf(trials.all)),
                             .at_most = kRatioMax});
  outcome.figures.push_back(
      {.name = "woken in the step of contact" + series, .unit = "boxes", .value = woken, .at_least = 1});
  outcome.others =
      std::max(outcome.others, std::ranges::max(Each(trials.all, [](const Trial& t) { return t.others; })));
}

}  // namespace

Outcome MeasureWoken(const Bench& bench) {
  Outcome outcome{
      .scene = "woken", .engine = bench.engine, .rounds = bench.plan.trials, .rounds_taken = bench.plan.trials};
  AddTo(outcome, "", static_cast<size_t>(kPile.row) * kPile.row * kPile.layers, HitPiles(bench));
  constexpr size_t kMany = static_cast<size_t>(kRowOfMany) * kRowOfMany;
  AddTo(outcome, ", one of many", kMany, HitOnesOfMany(bench, BallOnto));
  AddTo(outcome, ", one of many from the side", kMany, HitOnesOfMany(bench, BoxAgainst));
  return outcome;
}

}  // namespace genphys::bench

// What others cost that have nothing to do with what happens.
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <utility>

#include "case.h"
#include "genphys/client/client.h"
#include "local_world.h"
#include "support/must.h"
#include "viewer.h"

namespace genphys::bench {
namespace {

constexpr std::array<size_t, 3> kCounts{1'000, 10'000, 100'000};
// Bars: what N = 10,000 may cost, as a multiple of none, and what a body more may cost per step, ns.
constexpr double kRatioMax = 2;
constexpr double kSlopeMax = 0.5;

constexpr double kStepsPerSecond = 60;
constexpr double kSide = 1;   // m, of every box
constexpr double kGap = 0.2;  // m, from the passer to those beside its path, and between these
constexpr double kSpeed = 6;  // m/s
constexpr size_t kRow = 500;  // boxes along the path, in rows on both sides of it
constexpr double kPathEnd = (kSide + kGap) * kRow / 2 - kSide;  // m, from the middle: to the last box of a row
// m and m/s: the path is straight and nothing brakes. A solver leaves some of it.
constexpr double kAsideMax = 0.01;
constexpr double kSpeedLossMax = 0.01;
// A frame of the passer alone is far smaller, and one of 1,000 rows far larger.
constexpr size_t kDeltaBytesMax = 1'000;

// Who is beside the path.
struct Crowd {
  const char* series;
  MotionType motion_type = MotionType::kDynamic;
  bool is_joined = false;  // by twos
};

constexpr Crowd kCrowds[]{{.series = "asleep"},
                          {.series = "asleep on joints", .is_joined = true},
                          {.series = "static", .motion_type = MotionType::kStatic}};

// Beside the path, the nearest first, alternately on the left and on the right.
std::vector<EntityDesc> Bystanders(size_t count, MotionType motion_type) {
  std::vector<EntityDesc> bystanders;
  for (size_t i = 0; i < count; ++i) {
    const size_t row = i / kRow;
    const double side = row % 2 == 0 ? 1 : -1;
    const double x = (kSide + kGap) * (static_cast<double>(i % kRow) - (kRow - 1) / 2.0);
    const double y = side * (kSide + kGap) * static_cast<double>(1 + row / 2);
    bystanders.push_back(BoxOf({x, y, kSide / 2}));
    bystanders.back().rigid_body->motion_type = motion_type;
  }
  return bystanders;
}

WorldDesc WorldOf(const std::string& engine) {
  // They are put where they lie, so that nothing is left to wait for.
  constexpr double kRestTime = 0.05;
  WorldDesc desc{.engine = engine};
  desc.default_auto_disable.rest_time = kRestTime;
  return desc;
}

// One box on its way to and fro between `count` others.
class Passage {
 public:
  Passage(const Bench& bench, size_t count, const Crowd& crowd)
      : count_(count),
        sleepers_(crowd.motion_type == MotionType::kDynamic ? count : 0),
        local_(bench.registry, WorldOf(bench.engine), Bystanders(count, crowd.motion_type)) {
    if (crowd.is_joined) JoinByTwos();
    local_.AwaitSleep(sleepers_);
    passer_ = local_.Add(
        client::Body(Box{Vector3::Constant(kSide / 2)},
                     {.position = {0, 0, kSide / 2}, .mass = 1, .friction = 0, .linear_velocity = {kSpeed, 0, 0}}));
    // It takes a step of the flight lane, and then the floor holds it.
    StepAndLook();
    StepAndLook();
  }

  void Step() { local_.Step(); }

  void StepAndLook() {
    local_.Step();
    viewer_.Look(local_.world());
  }

  // Turns round where the path would not do for `steps`. The world is as it should be until here.
  void Prepare(uint32_t steps) {
    CheckUndisturbed();
    const double distance = kSpeed * steps / kStepsPerSecond;
    if (distance > kPathEnd) throw std::runtime_error("the path is too short");
    const double x = local_.world().state().positions(0, passer_.index());
    const double way = local_.world().state().linear_velocities(0, passer_.index()) > 0 ? 1 : -1;
    if (std::abs(x + way * distance) < kPathEnd) return;
    const Command turn = SetVelocity{.id = passer_, .linear = Vector3(-way * kSpeed, 0, 0)};
    local_.Apply(turn);
    viewer_.Follow(local_.world(), turn);
  }

  void CheckUndisturbed() const {
    const StateArrays& state = local_.world().state();
    if (local_.asleep() != sleepers_) throw std::runtime_error("the passer has woken somebody");
    const Vector3 position = state.positions.col(passer_.index());
    const Vector3 velocity = state.linear_velocities.col(passer_.index());
    const bool is_on_path = std::abs(position.y()) < kAsideMax && std::abs(position.x()) < kPathEnd + kSide;
    if (!is_on_path || std::abs(velocity.norm() - kSpeed) > kSpeedLossMax) {
      throw std::runtime_error("the passer has left its path");
    }
    if (count_ > 0 && viewer_.bytes() > kDeltaBytesMax) {
      throw std::runtime_error("a frame has more than the passer in it");
    }
  }

  StepStats Explain() {
    const StepStats stats = local_.Explain();
    if (stats.entities_in_engine != 1) throw std::runtime_error("the passer is not in the engine's lane");
    return stats;
  }

 private:
  void JoinByTwos() {
    std::vector<Command> commands;
    for (size_t i = 1; i < local_.ids().size(); i += 2) {
      commands.push_back(CreateJoint{
          {.entity_a = {.id = local_.ids()[i - 1]}, .entity_b = {.id = local_.ids()[i]}, .kind = FixedJoint{}}});
    }
    Must(local_.world().Apply(commands));
  }

  size_t count_;
  size_t sleepers_;
  LocalWorld local_;
  EntityId passer_;
  Viewer viewer_;
};

class Passages {
 public:
  explicit Passages(const Bench& bench) : bench_(bench) {
    Add("alone", 0, {.series = "alone"});
    for (const Crowd& crowd : kCrowds) {
      for (const size_t count : kCounts) Add(NameOf(crowd.series, count), count, crowd);
    }
  }

  Outcome Measure() {
    const Race race = TakeTurns(parties_, bench_.plan, bench_.engine + " passer");
    for (const auto& passage : passages_) passage->CheckUndisturbed();
    Outcome outcome = Describe("passer", bench_.engine, parties_, race);
    for (const auto& [series, motion_type, is_joined] : kCrowds) {
      const size_t some = PlaceOf(parties_, NameOf(series, kCounts[1]));
      const size_t many = PlaceOf(parties_, NameOf(series, kCounts[2]));
      outcome.figures.push_back({.name = NameOf(series, kCounts[1]) + " / alone",
                                 .value = SpreadOf(race.Ratios(some, PlaceOf(parties_, "alone"))),
                                 .at_most = kRatioMax});
      std::vector<double> slopes;
      for (size_t i = 0; i < race.costs[some].size(); ++i) {
        slopes.push_back(1e3 * (race.costs[many][i] - race.costs[some][i]) /
                         static_cast<double>(kCounts[2] - kCounts[1]));
      }
      outcome.figures.push_back({.name = std::string("one more that is ") + series,
                                 .unit = "ns",
                                 .value = SpreadOf(slopes),
                                 .at_most = kSlopeMax});
    }
    return outcome;
  }

 private:
  static std::string NameOf(const std::string& series, size_t count) { return WithCommas(count) + ' ' + series; }

  void Add(const std::string& name, size_t count, const Crowd& crowd) {
    const std::string series = crowd.series;
    std::fprintf(stderr, "%s passer: %s\n", bench_.engine.c_str(), name.c_str());
    Passage& passage = *passages_.emplace_back(std::make_unique<Passage>(bench_, count, crowd));
    const auto prepare = [&passage](uint32_t steps) { passage.Prepare(steps); };
    parties_.push_back({.series = series,
                        .name = name,
                        .size = static_cast<double>(count),
                        .step = [&passage] { passage.StepAndLook(); },
                        .prepare = prepare,
                        .explain = [&passage] { return passage.Explain(); }});
    parties_.push_back({.series = series + ", no frame",
                        .name = name + ", no frame",
                        .size = static_cast<double>(count),
                        .step = [&passage] { passage.Step(); },
                        .prepare = prepare});
  }

  const Bench& bench_;
  std::vector<std::unique_ptr<Passage>> passages_;
  std::vector<Party> parties_;
};

}  // namespace

Outcome MeasurePasser(const Bench& bench) { return Passages(bench).Measure(); }

}  // namespace genphys::bench

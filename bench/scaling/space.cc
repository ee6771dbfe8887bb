// What a collision space costs whose members touch nothing.
#include <array>
#include <memory>
#include <stdexcept>
#include <utility>

#include "case.h"
#include "genphys/client/client.h"
#include "local_world.h"

namespace genphys::bench {
namespace {

constexpr size_t kRow = 10;
constexpr size_t kMembers = kRow * kRow * kRow;
// Bar: no more than without the space, but for what two measurements of the same differ by.
constexpr double kRatioMax = 1.05;
// Bar: members that overlap are no dearer than those that do not.
constexpr double kCrowdRatioMax = 1.2;

constexpr double kSide = 1;            // m
constexpr double kWide = 1;            // m, gaps in which nobody is near anybody
constexpr double kNarrow = 0.01;       // m, gaps that are too wide to touch and too narrow to fly on unasked
constexpr double kCrowded = -0.999;    // m: all overlap
constexpr double kMembersSpeed = 0.5;  // m/s
// Part of it by which rows differ that move beside each other, so that not all members leave the places where they were
// last seen in the same step, and no step is one of all that work and the next of none.
constexpr double kSpeedSpread = 0.5;

struct Setting {
  std::string name;
  double gap = kWide;
  double speed = 0;
  double spread = 0;  // of the speed, as a part of it
};

// Members float high above the floor; far from them a box slides over it without friction.
std::vector<EntityDesc> BodiesOf(const Setting& setting, const std::string& collision_space) {
  constexpr double kHeight = 10;  // m
  constexpr double kAway = 100;   // m
  constexpr double kSliding = 1;  // m/s
  std::vector<EntityDesc> bodies;
  for (size_t i = 0; i < kMembers; ++i) {
    const Vector3 place(static_cast<double>(i % kRow), static_cast<double>(i / kRow % kRow),
                        static_cast<double>(i / kRow / kRow));
    const double rows_before = static_cast<double>(i / kRow) * kRow / kMembers;  // as a part of all
    bodies.push_back(client::Body(Box{Vector3::Constant(kSide / 2)},
                                  {.position = (kSide + setting.gap) * place + Vector3(0, 0, kHeight),
                                   .mass = 1,
                                   .linear_velocity = {setting.speed * (1 + setting.spread * rows_before), 0, 0},
                                   .gravity_scale = 0,
                                   .collision_space = collision_space}));
  }
  bodies.push_back(client::Body(
      Box{Vector3::Constant(kSide / 2)},
      {.position = {0, -kAway, kSide / 2}, .mass = 1, .friction = 0, .linear_velocity = {kSliding, 0, 0}}));
  return bodies;
}

// Some worlds of the same, which step in turn: where the memory of one happens to lie must not decide.
class Worlds {
 public:
  Worlds(const Bench& bench, const Setting& setting, const std::string& collision_space)
      : asleep_(setting.speed == 0 ? kMembers : 0) {
    for (auto& local : locals_) {
      local = std::make_unique<LocalWorld>(bench.registry, WorldDesc{.engine = bench.engine},
                                           BodiesOf(setting, collision_space));
      local->AwaitSleep(asleep_);
    }
  }

  void Step() { locals_[next_++ % locals_.size()]->Step(); }
  StepStats Explain() { return locals_.front()->Explain(); }

  void CheckUntouched() const {
    for (const auto& local : locals_) {
      if (local->asleep() != asleep_) throw std::runtime_error("a member does as it should not");
      for (const TouchingPair& touching : local->world().layer_state().touching) {
        const EntityId floor = local->world().state().ids.front();
        if (touching.pair.a != floor) throw std::runtime_error("a member touches another");
      }
    }
  }

 private:
  std::array<std::unique_ptr<LocalWorld>, 4> locals_;
  size_t asleep_;
  size_t next_ = 0;
};

// Members that are all in the same place, against members that are not near each other.
void MeasureCrowd(const Bench& bench, Outcome& outcome) {
  const Setting apart{.name = "apart", .speed = kMembersSpeed};
  const Setting crowded{.name = "all in one place", .gap = kCrowded, .speed = kMembersSpeed};
  Worlds few(bench, apart, "swarm"), many(bench, crowded, "swarm");
  const auto party = [&](const Setting& setting, Worlds& worlds) {
    return Party{.series = setting.name,
                 .name = "members of one space, " + setting.name,
                 .size = static_cast<double>(kMembers),
                 .step = [&worlds] { worlds.Step(); },
                 .explain = [&worlds] { return worlds.Explain(); }};
  };
  const std::vector<Party> parties{party(apart, few), party(crowded, many)};
  const Race race = TakeTurns(parties, bench.plan, bench.engine + " space, all in one place");
  few.CheckUntouched();
  many.CheckUntouched();
  Outcome found = Describe("space", bench.engine, parties, race);
  found.figures = {{.name = "members of one space, all in one place / apart",
                    .value = SpreadOf(race.Ratios(1, 0)),
                    .at_most = kCrowdRatioMax}};
  Append(std::move(found), outcome);
}

void Measure(const Bench& bench, const Setting& setting, Outcome& outcome) {
  Worlds without(bench, setting, ""), with(bench, setting, "swarm");
  const auto party = [&](const std::string& series, Worlds& worlds) {
    return Party{.series = series,
                 .name = setting.name + ", " + series,
                 .size = static_cast<double>(kMembers),
                 .step = [&worlds] { worlds.Step(); },
                 .explain = [&worlds] { return worlds.Explain(); }};
  };
  const std::vector<Party> parties{party("no space", without), party("one space", with)};
  const Race race = TakeTurns(parties, bench.plan, bench.engine + " space, " + setting.name);
  without.CheckUntouched();
  with.CheckUntouched();
  Outcome found = Describe("space", bench.engine, parties, race);
  found.figures = {
      {.name = setting.name + ", one space / none", .value = SpreadOf(race.Ratios(1, 0)), .at_most = kRatioMax}};
  Append(std::move(found), outcome);
}

}  // namespace

Outcome MeasureSpace(const Bench& bench) {
  Outcome outcome{.scene = "space", .engine = bench.engine};
  const std::array<Setting, 3> kSettings{
      {{.name = "members sleep"},
       {.name = "members move", .speed = kMembersSpeed, .spread = kSpeedSpread},
       {.name = "members move close together", .gap = kNarrow, .speed = kMembersSpeed, .spread = kSpeedSpread}}};
  for (const Setting& setting : kSettings) Measure(bench, setting, outcome);
  MeasureCrowd(bench, outcome);
  return outcome;
}

}  // namespace genphys::bench

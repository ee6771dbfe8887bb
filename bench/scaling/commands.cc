// What commands cost in small and in large batches.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "case.h"
#include "contenders/clock.h"
#include "genphys/client/client.h"
#include "local_world.h"
#include "support/must.h"
#include "support/quiet.h"

namespace genphys::bench {
namespace {

// Bodies that lie on the floor by twos, one on the other, and are asleep.
constexpr size_t kFew = 2'000;
constexpr size_t kMany = 16'000;
// Bar: what one of many costs, as a multiple of one of few. What grew with their number would cost 8 times as much;
// memory that no cache holds costs some of it.
constexpr double kRatioMax = 3;
constexpr double kSide = 1;  // m, of every box

struct Kind {
  const char* name;
  // One for each body; `i` counts these.
  Command (*command)(EntityId id, size_t i);
  // What comes before and is not timed, or null.
  Command (*before)(EntityId id, size_t i) = nullptr;
};

Command Push(EntityId id, size_t) { return ApplyForce{.id = id, .force = {1, 0, 0}, .steps = 100}; }

const Kind kKinds[]{
    {"apply force", Push},
    {"replace force",
     [](EntityId id, size_t) -> Command {
       return ApplyForce{.id = id, .force = {0, 1, 0}, .steps = 100, .replace = true};
     },
     Push},
    {"apply impulse",
     [](EntityId id, size_t) -> Command {
       return ApplyImpulse{.id = id, .linear = {0, 0, 0.01}};
     }},
    {"set velocity",
     [](EntityId id, size_t) -> Command { return SetVelocity{.id = id, .linear = Vector3(0, 0, 0.1)}; }},
    {"set pose",
     [](EntityId id, size_t i) -> Command {
       return SetPose{.id = id, .position = Vector3(0, 0, 10 + 2 * kSide * static_cast<double>(i))};
     }},
    {"join to the world",
     [](EntityId id, size_t) -> Command { return CreateJoint{{.entity_b = {.id = id}, .kind = BallJoint{}}}; }},
    {"delete", [](EntityId id, size_t) -> Command { return DeleteEntity{id}; }},
    {"delete what is joined", [](EntityId id, size_t) -> Command { return DeleteEntity{id}; },
     [](EntityId id, size_t) -> Command { return CreateJoint{{.entity_b = {.id = id}, .kind = BallJoint{}}}; }},
};

std::vector<EntityDesc> Pairs(size_t bodies) {
  std::vector<EntityDesc> pairs;
  constexpr size_t kRow = 100;
  for (size_t i = 0; i < bodies; ++i) {
    const Vector3 place(static_cast<double>(i / 2 % kRow), static_cast<double>(i / 2 / kRow), 0);
    pairs.push_back(BoxOf(2 * kSide * place + Vector3(0, 0, i % 2 == 0 ? 0.5 : 1.5) * kSide));
  }
  return pairs;
}

std::vector<Command> ForEach(const LocalWorld& local, Command (*command)(EntityId, size_t)) {
  std::vector<Command> commands;
  for (size_t i = 0; i < local.ids().size(); ++i) commands.push_back(command(local.ids()[i], i));
  return commands;
}

// us of processor time for each command of one batch for all bodies.
double CostOf(const Bench& bench, const Kind& kind, size_t bodies) {
  LocalWorld local(bench.registry, {.engine = bench.engine}, Pairs(bodies));
  local.AwaitSleep(bodies);
  if (kind.before != nullptr) Must(local.world().Apply(ForEach(local, kind.before)));
  const std::vector<Command> commands = ForEach(local, kind.command);
  const double begin = ProcessorTime();
  Must(local.world().Apply(commands));
  const double cost = 1e6 * (ProcessorTime() - begin) / static_cast<double>(bodies);
  local.Step();
  return cost;
}

}  // namespace

Outcome MeasureCommands(const Bench& bench) {
  Outcome outcome{.scene = "commands", .engine = bench.engine};
  OthersWatch others{{}};
  // They take long to set up.
  const int rounds = std::max(1, bench.plan.trials / 10);
  outcome.rounds = outcome.rounds_taken = rounds;
  others.Begin();
  for (const Kind& kind : kKinds) {
    std::fprintf(stderr, "%s commands: %s\n", bench.engine.c_str(), kind.name);
    std::vector<double> few, many, ratios;
    for (int i = 0; i < rounds; ++i) {
      few.push_back(CostOf(bench, kind, kFew));
      many.push_back(CostOf(bench, kind, kMany));
      ratios.push_back(many.back() / few.back());
    }
    for (const auto& [bodies, costs] : {std::pair(kFew, &few), std::pair(kMany, &many)}) {
      outcome.costs.push_back({.series = kind.name,
                               .name = std::string(kind.name) + ", " + WithCommas(bodies),
                               .size = static_cast<double>(bodies),
                               .step = SpreadOf(*costs)});
    }
    outcome.figures.push_back(
        {.name = std::string(kind.name) + ", one of " + WithCommas(kMany) + " / one of " + WithCommas(kFew),
         .value = SpreadOf(ratios),
         .at_most = kRatioMax});
  }
  outcome.others = others.End();
  return outcome;
}

}  // namespace genphys::bench

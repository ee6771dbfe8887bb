// What a world costs that has nothing in it, and a server of many that have nothing to do.
#include <malloc.h>

#include <chrono>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <thread>

#include "case.h"
#include "contenders/contender.h"
#include "contenders/raw_bullet.h"
#include "contenders/raw_ode.h"
#include "genphys/client/client.h"
#include "local_world.h"
#include "support/must.h"
#include "support/server_process.h"

namespace genphys::bench {
namespace {

// Bars: us and kB of an empty world, and percent of a processor for a server that nobody asks for anything.
constexpr double kCreationMax = 1'000;
constexpr double kHeapMax = 250;
constexpr double kIdleMax = 0.1;

constexpr size_t kServedWorlds = 1'000;
constexpr size_t kBodies = 20;  // of each

std::unique_ptr<Simulation> RawWorld(const std::string& engine) {
  const Scene scene{.has_ground = true};
  return RawContenders(engine).front().start(scene);
}

double HeapInUse() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

// kB of each of some that `make` makes, on average.
template <typename Make>
double HeapOf(Make make) {
  constexpr size_t kWorlds = 32;
  std::vector<decltype(make())> worlds(kWorlds);
  // What is made once for all is there afterwards.
  make();
  const double before = HeapInUse();
  for (auto& world : worlds) world = make();
  return (HeapInUse() - before) / kWorlds / 1000;
}

void MeasureEmpty(const Bench& bench, Outcome& outcome) {
  const WorldDesc desc{.engine = bench.engine};
  const auto ours = [&] { return Must(World::Create(bench.registry, desc)); };
  const auto raw = [&] { return RawWorld(bench.engine); };
  // An engine starts its library with its first world and ends it with its last one.
  const std::unique_ptr<Simulation> first = raw();
  const std::vector<Party> parties{
      {.series = "ours", .name = "an empty world", .size = 1, .step = [&] { ours(); }},
      {.series = "alone", .name = "the same of the engine alone", .size = 1, .step = [&] { raw(); }}};
  Outcome found = Describe("worlds", bench.engine, parties, TakeTurns(parties, bench.plan, bench.engine + " worlds"));
  found.figures = {{.name = "an empty world, created and destroyed",
                    .unit = "µs",
                    .value = found.costs[0].step,
                    .at_most = kCreationMax},
                   {.name = "the same of the engine alone", .unit = "µs", .value = found.costs[1].step},
                   {.name = "heap of an empty world", .unit = "kB", .value = Once(HeapOf(ours)), .at_most = kHeapMax},
                   {.name = "heap of one of the engine alone", .unit = "kB", .value = Once(HeapOf(raw))}};
  Append(std::move(found), outcome);
}

// A server's worlds of boxes that lie on the floor.
class Served {
 public:
  Served(const Bench& bench)
      : bench_(bench), process_(bench.server), server_(Must(client::Connect(process_.address()))) {}

  void MakeWorlds() {
    constexpr double kSpacing = 2;  // m
    std::vector<Command> boxes;
    for (size_t i = 0; i < kBodies; ++i) {
      boxes.push_back(CreateEntity{BoxOf({kSpacing * static_cast<double>(i), 0, 0.5})});
    }
    while (worlds_.size() < kServedWorlds) {
      worlds_.push_back(Must(server_.CreateWorld({.world = {.engine = bench_.engine}})));
      Must(worlds_.back().Apply(boxes));
    }
  }

  void AwaitSleep() {
    constexpr uint32_t kSteps = 60;
    for (client::World& world : worlds_) {
      const client::Frame frame = Must(world.Step(kSteps)).frame;
      size_t asleep = 0;
      for (uint32_t row = 0; row < frame.rows(); ++row) asleep += frame.asleep(row) ? 1 : 0;
      if (asleep != kBodies) throw std::runtime_error("the boxes of a world do not sleep");
    }
  }

  void Play() {
    for (client::World& world : worlds_) Check(world.Play());
  }
  void Pause() {
    for (client::World& world : worlds_) Check(world.Pause());
  }

  // Percent of a processor that the server takes while nobody asks it for anything.
  double Idle() const {
    // What the last calls left to do is done by then.
    constexpr std::chrono::milliseconds kPause{500};
    std::this_thread::sleep_for(kPause);
    const double begin = process_.process().cpu_time();
    std::this_thread::sleep_for(std::chrono::duration<double>(bench_.plan.watch_seconds));
    return 100 * (process_.process().cpu_time() - begin) / bench_.plan.watch_seconds;
  }

 private:
  const Bench& bench_;
  ServerProcess process_;
  client::Server server_;
  std::vector<client::World> worlds_;
};

void MeasureServed(const Bench& bench, Outcome& outcome) {
  const auto add = [&](const std::string& name, double percent, std::optional<double> most) {
    std::fprintf(stderr, "%s worlds: %s: %.4f %%\n", bench.engine.c_str(), name.c_str(), percent);
    outcome.figures.push_back({.name = name, .unit = "% of a processor", .value = Once(percent), .at_most = most});
  };
  const std::string worlds = WithCommas(kServedWorlds) + " worlds of " + std::to_string(kBodies) + " bodies";
  Served served(bench);
  add("a server without worlds", served.Idle(), kIdleMax);
  served.MakeWorlds();
  add(worlds + " that nobody has stepped", served.Idle(), kIdleMax);
  served.AwaitSleep();
  add(worlds + " that sleep", served.Idle(), kIdleMax);
  served.Play();
  add(worlds + " that sleep and play", served.Idle(), std::nullopt);
  served.Pause();
  add(worlds + " that have played and are paused", served.Idle(), kIdleMax);
}

}  // namespace

Outcome MeasureWorlds(const Bench& bench) {
  Outcome outcome{.scene = "worlds", .engine = bench.engine};
  MeasureEmpty(bench, outcome);
  MeasureServed(bench, outcome);
  return outcome;
}

}  // namespace genphys::bench

#include "worlds.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <vector>

#include "contenders.h"
#include "genphys/client/client.h"
#include "scenes.h"
#include "support/quiet.h"

namespace genphys::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t kWorlds = 64;
constexpr uint32_t kBodies = 50;
constexpr uint32_t kStepsPerTurn = 5;

class Worlds {
 public:
  Worlds(const Parties& parties, const std::string& engine) : server_(Must(client::Connect(parties.address))) {
    const Scene scene = PileOf(engine, kBodies);
    for (size_t i = 0; i < kWorlds; ++i) {
      in_process_.push_back(std::make_unique<InProcess>(parties.registry, scene));
      served_.push_back(MakeWorld(parties.address, scene));
      wanted_.push_back({served_.back().name(), 1, {}});
    }
    for (uint32_t i = 0; i < scene.steps_before; ++i) StepInProcess(), StepServed();
  }

  void StepInProcess() {
    for (const auto& world : in_process_) world->Advance(1);
  }
  void StepServed() {
    for (const Result<client::StepResult>& result : server_.StepWorlds(wanted_)) Check(result.status());
  }
  void CheckStates() {
    for (size_t i = 0; i < kWorlds; ++i) {
      CheckSame(in_process_[i]->state(), Must(served_[i].Step(0)).frame, "call of StepWorlds");
    }
  }

 private:
  client::Server server_;
  std::vector<std::unique_ptr<InProcess>> in_process_;
  std::vector<client::World> served_;
  std::vector<client::WorldSteps> wanted_;
};

struct Round {
  double one_thread = 0;
  double step_worlds = 0;
  double others = 0;
};

template <typename Work>
double MeanTime(Work work) {
  const Clock::time_point begin = Clock::now();
  for (uint32_t i = 0; i < kStepsPerTurn; ++i) work();
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count() / kStepsPerTurn;
}

}  // namespace

WorldsOutcome MeasureWorlds(const Parties& parties, const std::string& engine, const Plan& plan) {
  std::fprintf(stderr, "%-8s %zu worlds\n", engine.c_str(), kWorlds);
  Worlds worlds(parties, engine);
  OthersWatch others({&parties.server, &parties.bytes_echo.server(), &parties.message_echo.server(), &parties.python});
  const Clock::time_point end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(plan.seconds_per_scene));
  std::vector<Round> rounds;
  const auto wanted = static_cast<size_t>(plan.rounds);
  for (size_t undisturbed = 0; undisturbed < wanted && (rounds.size() < wanted || Clock::now() < end);) {
    Round round;
    others.Begin();
    round.one_thread = MeanTime([&] { worlds.StepInProcess(); });
    round.step_worlds = MeanTime([&] { worlds.StepServed(); });
    round.others = others.End();
    undisturbed += round.others <= kOthersMax ? 1 : 0;
    rounds.push_back(round);
  }
  worlds.CheckStates();
  std::sort(rounds.begin(), rounds.end(), [](const Round& a, const Round& b) { return a.others < b.others; });
  rounds.resize(std::min(rounds.size(), wanted));
  std::vector<double> one_thread, step_worlds, speedup;
  for (const Round& round : rounds) {
    one_thread.push_back(round.one_thread);
    step_worlds.push_back(round.step_worlds);
    speedup.push_back(round.one_thread / round.step_worlds);
  }
  return {engine,
          kWorlds,
          kBodies,
          static_cast<int>(rounds.size()),
          rounds.back().others,
          SpreadOf(one_thread),
          SpreadOf(step_worlds),
          SpreadOf(speedup)};
}

}  // namespace genphys::bench

#include "measure.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <stdexcept>
#include <utility>

#include "support/quiet.h"

namespace genphys::bench {
namespace {

using Clock = std::chrono::steady_clock;

// Everything is done this often before a round counts, so that code, caches and connections are warm.
constexpr int kWarmUpRounds = 3;
// A turn takes about this long: long enough that its first step, which is not timed, warms it up, and short enough that
// whatever disturbs the machine disturbs all of them.
constexpr double kTurnMicroseconds = 40'000;
constexpr uint32_t kStepsPerTurnMin = 5;
constexpr uint32_t kStepsPerTurnMax = 200;
// Whoever calls or drives needs this long after others had the machine until the threads at both ends have found their
// processors: with 1,000 flyers on two of them a step that is driven takes 230 to 250 us after 60 ms, 210 after 300 ms,
// and no less after that; a cycle of sleepers that is not given it took from 66 to 123 us on a busy machine.
constexpr double kRunInMicroseconds = 300'000;

struct Round {
  Times in_process;
  Times bytes_echo;
  Times message_echo;
  Times cpp;
  Times drive;
  Times python;
  size_t request_bytes = 0;
  size_t reply_bytes = 0;
  double others = 0;

  // Of means, for steps of the same world need not cost the same: who moves leaves the place in the search tree that it
  // was given now and then, and a rate is one over the mean.
  double DriveToSlower() const { return std::max(Mean(in_process), Mean(bytes_echo)) / Mean(drive); }
  double RatioTo(const Times& echo) const { return Mean(cpp) / (Mean(in_process) + Mean(echo)); }
};

class Race {
 public:
  Race(const Parties& parties, const Scene& scene)
      : bytes_echo_(parties.bytes_echo),
        message_echo_(parties.message_echo),
        in_process_(parties.registry, scene),
        cpp_(parties.address, scene),
        drive_(parties.address, scene),
        python_(parties.python, parties.address, scene),
        others_({&parties.server, &parties.bytes_echo.server(), &parties.message_echo.server(), &parties.python}) {
    Advance(scene.steps_before);
    if (scene.ends_up_asleep) CheckAsleep();
    captured_ = cpp_.Capture();
    in_process_.Advance(1);
    drive_.Advance(1);
    python_.Advance(1);
  }

  // Every way gets its turn; none is always the one that comes after the same other. Before it is measured for `steps`
  // it goes on by `run_in`.
  Round Take(uint32_t run_in, uint32_t steps) {
    Round round;
    others_.Begin();
    const std::array<std::function<void()>, 6> turns{[&] { round.in_process = Turn(in_process_, run_in, steps); },
                                                     [&] { round.bytes_echo = Turn(bytes_echo_, run_in, steps); },
                                                     [&] { TakeCpp(round, run_in, steps); },
                                                     [&] { round.message_echo = Turn(message_echo_, run_in, steps); },
                                                     [&] { round.python = Turn(python_, run_in, steps); },
                                                     [&] { round.drive = drive_.Measure(run_in, steps + 1); }};
    for (size_t i = 0; i < turns.size(); ++i) turns[(first_ + i) % turns.size()]();
    ++first_;
    round.others = others_.End();
    return round;
  }

  // Call between rounds, when all worlds are at the same step.
  Outcome Describe(const Scene& scene) {
    const client::Frame frame = cpp_.Look();
    CheckSame(in_process_.state(), frame, "C++ client");
    CheckSame(in_process_.state(), drive_.Look(), "drive");
    CheckSame(in_process_.state(), python_.Look(), "Python client");
    return {.engine = scene.world.engine,
            .scene = scene.name,
            .rows = frame.rows(),
            .contacts = in_process_.contacts(),
            .steps = frame.stamp().step};
  }

 private:
  template <typename Contender>
  static Times Turn(Contender& contender, uint32_t run_in, uint32_t steps) {
    Times times = contender.Measure(run_in + 1 + steps);
    times.erase(times.begin(), times.end() - steps);
    return times;
  }

  // An echo carries what a cycle carried last, which is of about the same step.
  Times Turn(Echo& echo, uint32_t run_in, uint32_t steps) const {
    echo.Carry(captured_.request, captured_.reply);
    MeasureEcho(echo, run_in);
    return MeasureEcho(echo, steps);
  }

  void TakeCpp(Round& round, uint32_t run_in, uint32_t steps) {
    cpp_.Measure(run_in);
    captured_ = cpp_.Capture();
    round.cpp = cpp_.Measure(steps);
    round.request_bytes = captured_.request.size();
    round.reply_bytes = captured_.reply.size();
  }

  void Advance(uint32_t steps) {
    in_process_.Advance(steps);
    cpp_.Advance(steps);
    drive_.Advance(steps);
    python_.Advance(steps);
  }

  void CheckAsleep() {
    const client::Frame frame = cpp_.Look();
    uint32_t asleep = 0;
    for (uint32_t row = 0; row < frame.rows(); ++row) asleep += frame.asleep(row) ? 1 : 0;
    if (asleep < kSceneEntities) throw std::runtime_error("only " + std::to_string(asleep) + " entities fell asleep");
  }

  Echo& bytes_echo_;
  Echo& message_echo_;
  InProcess in_process_;
  CppCycle cpp_;
  CppDrive drive_;
  PythonCycle python_;
  OthersWatch others_;
  Exchange captured_;
  size_t first_ = 0;
};

uint32_t StepsPerTurn(double cycle) {
  return static_cast<uint32_t>(
      std::clamp(std::ceil(kTurnMicroseconds / cycle), double{kStepsPerTurnMin}, double{kStepsPerTurnMax}));
}

uint32_t RunIn(double cycle) { return static_cast<uint32_t>(std::ceil(kRunInMicroseconds / cycle)); }

// Undisturbed rounds, as many as are wanted. If time runs out before, those that others disturbed least.
std::vector<Round> TakeRounds(Race& race, const Scene& scene, const Plan& plan, int* taken) {
  uint32_t run_in = 1, steps = kStepsPerTurnMin;
  for (int i = 0; i < kWarmUpRounds; ++i) {
    const double cycle = Mean(race.Take(run_in, steps).cpp);
    run_in = RunIn(cycle);
    steps = StepsPerTurn(cycle);
  }
  const Clock::time_point end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(plan.seconds_per_scene));
  std::vector<Round> rounds;
  int undisturbed = 0;
  const auto wanted = static_cast<size_t>(plan.rounds);
  for (bool is_last = false; !is_last;) {
    rounds.push_back(race.Take(run_in, steps));
    if (rounds.back().others <= kOthersMax) ++undisturbed;
    is_last = undisturbed >= plan.rounds || (rounds.size() >= wanted && Clock::now() >= end);
    // A line that overwrites itself is for people alone.
    if (isatty(STDERR_FILENO) == 0 && !is_last) continue;
    std::fprintf(stderr, "\r%-8s %-9s %4zu rounds of %u steps, %3d of %d undisturbed%s", scene.world.engine.c_str(),
                 scene.name.c_str(), rounds.size(), steps, undisturbed, plan.rounds, is_last ? "\n" : "");
  }
  *taken = static_cast<int>(rounds.size());
  std::sort(rounds.begin(), rounds.end(), [](const Round& a, const Round& b) { return a.others < b.others; });
  rounds.resize(std::min(rounds.size(), wanted));
  return rounds;
}

Spread SpreadOverRounds(const std::vector<Round>& rounds, Times Round::*times) {
  std::vector<double> means;
  for (const Round& round : rounds) means.push_back(Mean(round.*times));
  return SpreadOf(means);
}

}  // namespace

Outcome Measure(const Parties& parties, const Scene& scene, const Plan& plan) {
  std::fprintf(stderr, "%-8s %-9s %u steps first\n", scene.world.engine.c_str(), scene.name.c_str(),
               scene.steps_before);
  Race race(parties, scene);
  int taken = 0;
  const std::vector<Round> rounds = TakeRounds(race, scene, plan, &taken);
  Outcome outcome = race.Describe(scene);
  outcome.rounds = static_cast<int>(rounds.size());
  outcome.rounds_taken = taken;
  outcome.others = rounds.back().others;
  outcome.in_process = SpreadOverRounds(rounds, &Round::in_process);
  outcome.bytes_echo = SpreadOverRounds(rounds, &Round::bytes_echo);
  outcome.message_echo = SpreadOverRounds(rounds, &Round::message_echo);
  outcome.cpp = SpreadOverRounds(rounds, &Round::cpp);
  outcome.drive = SpreadOverRounds(rounds, &Round::drive);
  outcome.python = SpreadOverRounds(rounds, &Round::python);
  std::vector<double> to_bytes_echo, to_message_echo, to_slower, replies;
  for (const Round& round : rounds) {
    to_bytes_echo.push_back(round.RatioTo(round.bytes_echo));
    to_message_echo.push_back(round.RatioTo(round.message_echo));
    to_slower.push_back(round.DriveToSlower());
    replies.push_back(static_cast<double>(round.reply_bytes));
  }
  outcome.to_bytes_echo = SpreadOf(to_bytes_echo);
  outcome.to_message_echo = SpreadOf(to_message_echo);
  outcome.drive_to_slower = SpreadOf(to_slower);
  outcome.request_bytes = rounds.front().request_bytes;
  outcome.reply_bytes = static_cast<size_t>(Median(replies));
  return outcome;
}

}  // namespace genphys::bench

#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "outcome.h"

namespace genphys::bench {

/// How much is measured.
struct Plan {
  int rounds = 40;            // that count, of each scene
  double seconds = 60;        // for each scene, after which it ends with what it has
  int trials = 30;            // of what happens once and cannot be repeated in the same world
  double watch_seconds = 10;  // for which a server that has nothing to do is looked at
};

/// What others use of the machine, in processors, while a round counts as undisturbed, is at most this.
inline constexpr double kOthersMax = 0.1;

/// Somebody who steps in turn with others.
struct Party {
  std::string series;
  std::string name;
  double size = 0;
  std::function<void()> step;
  /// Called before that many steps, which it may count on; not timed. May be empty.
  std::function<void(uint32_t steps)> prepare = {};
  /// Takes a step and says where its work went. May be empty.
  std::function<StepStats()> explain = {};
};

/// Where the party of that name is. There must be one.
size_t PlaceOf(const std::vector<Party>& parties, const std::string& name);

/// What steps cost, us of processor time: by party, and then by round: the mean of a turn.
struct Race {
  std::vector<std::vector<double>> costs;
  int rounds_taken = 0;
  double others = 0;  // most that others used in a round that counts, in processors

  /// Of two parties in the same rounds.
  std::vector<double> Ratios(size_t of, size_t to) const;
};

/// Takes rounds in which each party has a turn, until enough were undisturbed or time is over; then those count that
/// others disturbed least. `title` leads the lines of progress on standard error.
Race TakeTurns(const std::vector<Party>& parties, const Plan& plan, const std::string& title);

/// What a race came to, without figures.
Outcome Describe(const std::string& scene, const std::string& engine, const std::vector<Party>& parties,
                 const Race& race);

}  // namespace genphys::bench

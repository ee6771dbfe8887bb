#pragma once
#include <optional>
#include <string>
#include <vector>

#include "genphys/world.h"
#include "support/spread.h"

namespace genphys::bench {

/// What a step of one contender costs.
struct Cost {
  std::string series;              // what differs from others of it in size alone
  std::string name;                // unique in its outcome
  double size = 0;                 // bodies, islands or worlds that it is about
  Spread step;                     // us of processor time, over rounds
  std::optional<StepStats> lanes;  // of one step
};

/// A number that a scene comes to, and the bar for its median.
struct Figure {
  std::string name;
  std::string unit;  // empty: a ratio
  Spread value;
  std::optional<double> at_most;
  std::optional<double> at_least;
};

/// One scene on one engine.
struct Outcome {
  std::string scene;
  std::string engine;
  int rounds = 0;  // that count
  int rounds_taken = 0;
  double others = 0;  // most that others used in a round that counts, in processors
  std::vector<Cost> costs;
  std::vector<Figure> figures;
};

/// Adds what another race of the same scene on the same engine came to.
void Append(Outcome&& more, Outcome& outcome);

/// A value that is known once.
inline Spread Once(double value) { return {1, value, value, value}; }

}  // namespace genphys::bench

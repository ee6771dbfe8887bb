#pragma once
#include <optional>
#include <string>
#include <vector>

#include "case.h"
#include "contenders/contender.h"
#include "genphys/step_stats.h"
#include "sight.h"

namespace genphys::bench {

/// How much is measured.
struct Plan {
  int rounds = 3;         // from the begin of a scene to its end
  double seconds = 15;    // for one scene on one engine; no round begins later
  bool is_quick = false;  // once, and a few steps of each phase
};

/// The steps of a phase.
struct Span {
  long begin = 0;  // steps before it
  long end = 0;
};

/// One contender in one phase.
struct Cost {
  double step = 0;     // us of processor time per body that moves and step
  double dearest = 0;  // of a hundred steps all but one are cheaper: that in the place of the mean one
  double ratio = 0;    // of the cost to that of the first contender, median of rounds; zero: that has none
  double ratio_low = 0, ratio_high = 0;  // of single rounds
  Sight sight;                           // at the end of it
  std::optional<double> gauge;
  std::optional<StepStats> stats;  // sums over all steps, of the contender that is looked into
};

/// One contender in one scene.
struct Standing {
  std::string contender;
  std::string not_had;      // what it has not and the scene needs; empty: nothing
  std::string failure;      // why it did not come to the end
  std::vector<Cost> costs;  // by phase, if neither
};

/// One scene on one engine.
struct Outcome {
  std::string scene;
  std::string engine;
  size_t movers = 0;
  size_t others = 0;  // bodies that never move
  size_t joints = 0;
  int rounds = 0;
  double others_used = 0;   // most that other programs used in a round, in processors
  std::vector<Span> spans;  // by phase
  std::vector<Standing> standings;
};

/// Simulates a scene with all `contenders`, of one engine: the first one is what ratios are to, and where the time of
/// `explained` goes is told. Lines of progress go to standard error.
Outcome Measure(const Case& what, const std::vector<Contender>& contenders, const std::string& explained,
                const BackendRegistry& registry, const Plan& plan);

}  // namespace genphys::bench

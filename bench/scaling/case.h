#pragma once
#include <functional>
#include <string>
#include <vector>

#include "genphys/registry.h"
#include "outcome.h"
#include "turns.h"

namespace genphys::bench {

/// What a case is measured with.
struct Bench {
  const BackendRegistry& registry;
  std::string engine;
  std::string server;  // the program genphysd
  Plan plan;
};

/// A question of how cost grows.
struct Case {
  std::string id;
  std::string title;  // what happens
  std::function<Outcome(const Bench&)> measure;
};

/// All of them, in the order of the report.
std::vector<Case> Cases();

// One file each. Failures, and scenes that are not what they claim to be, are std::runtime_errors.
Outcome MeasurePasser(const Bench& bench);
Outcome MeasureAsleep(const Bench& bench);
Outcome MeasureWoken(const Bench& bench);
Outcome MeasureFlyers(const Bench& bench);
Outcome MeasurePile(const Bench& bench);
Outcome MeasureSmallPiles(const Bench& bench);
Outcome MeasureIslands(const Bench& bench);
Outcome MeasureSpace(const Bench& bench);
Outcome MeasureCommands(const Bench& bench);
Outcome MeasureWorlds(const Bench& bench);

}  // namespace genphys::bench

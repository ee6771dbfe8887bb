#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "contenders/scene.h"
#include "contenders/simulation.h"

namespace genphys::bench {

/// Of all dice.
inline constexpr uint32_t kSeed = 1;

/// A part of what happens, whose cost is told apart.
struct Phase {
  std::string name;
  double begin = 0;    // s of simulated time; what comes before it is not measured
  double seconds = 1;  // of simulated time
};

/// A number that says whether a scene is what it is said to be.
struct Gauge {
  std::string name;  // with its unit
  std::function<double(const Simulation&, const Scene&, double time)> read;
};

/// Something that people simulate every day.
struct Case {
  std::string id;
  std::string title;
  std::function<Scene()> make;
  std::vector<Phase> phases;  // one after the other
  int rate = 60;              // steps per second
  double lowest = -1;         // m: a body whose centre is lower is lost
  /// Before each step, with the time at its begin; a part of what the step costs. May be empty.
  std::function<void(Simulation&, double time)> drive = {};
  std::optional<Gauge> gauge = std::nullopt;
};

/// All of them, in the order of the report.
std::vector<Case> Cases();

void AddFigures(std::vector<Case>& cases);
void AddLinks(std::vector<Case>& cases);
void AddDriven(std::vector<Case>& cases);
void AddStacks(std::vector<Case>& cases);
void AddPoured(std::vector<Case>& cases);
void AddGrounds(std::vector<Case>& cases);

}  // namespace genphys::bench

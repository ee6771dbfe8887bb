#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "contenders/quantity.h"
#include "contenders/run.h"

namespace genphys::bench {

/// The largest value that a quantity of a trial may have.
struct Limit {
  std::string quantity;
  double largest = 0;
};

/// Something that must not break.
struct Trial {
  std::string id;     // "S1.15": a stress and its size
  std::string title;  // what happens
  std::function<std::vector<Quantity>(const Lab&, uint32_t seed)> run;
  std::vector<Limit> limits;   // passed if all hold for every seed
  std::vector<int> rates{60};  // steps per second
  uint32_t seeds = 1;          // from 1 on; a seed disturbs the start or chooses the scene
  bool needs_springs = false;  // which the engines alone do not have
  bool is_long = false;        // takes minutes
};

/// All of them, in the order of the report.
std::vector<Trial> Trials();

void AddStacks(std::vector<Trial>& trials);
void AddSpins(std::vector<Trial>& trials);
void AddLinks(std::vector<Trial>& trials);
void AddHits(std::vector<Trial>& trials);
void AddSoaks(std::vector<Trial>& trials);

}  // namespace genphys::bench

#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "contenders/quantity.h"
#include "genphys/registry.h"
#include "trial.h"

namespace genphys::bench {

/// One contender in one trial with one step size.
struct Outcome {
  std::string trial;
  std::string contender;
  int rate = 0;  // steps per second
  uint32_t seeds = 0;
  uint32_t passed = 0;          // of them
  std::vector<Quantity> worst;  // of all seeds
  std::string failure;          // of the last run that broke off
};

/// As JSON, with the trials and a description of the machine that does not name it.
std::string ToJson(const std::vector<Outcome>& outcomes, const std::vector<Trial>& trials,
                   const BackendRegistry& registry);

}  // namespace genphys::bench

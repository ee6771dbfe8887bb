#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "contenders/quantity.h"
#include "contenders/run.h"
#include "contenders/scene.h"

namespace genphys::bench {

/// Steps per second that problems are run with unless they say otherwise.
inline const std::vector<int> kRates{30, 60, 120, 240, 480, 1000, 2000};

/// A question whose answer is known from elsewhere.
struct Problem {
  std::string id;                                            // "B1"; a dot comes before a variant
  std::string title;                                         // what happens
  std::string error;                                         // what the error is, and by what it is divided
  Scene scene;                                               // of which the cost is measured
  double duration = 0;                                       // of which the cost is measured, s; zero: it is not
  std::function<std::vector<Quantity>(const Lab&)> measure;  // "error" comes first; none: only the cost counts
  /// The error that semi-implicit Euler must have, per second of step size: its places are behind by half a step's
  /// change of velocity.
  std::optional<double> euler_error;
  bool first_order = true;  // whether smaller steps can help at all
  StepPlan plan = StepPlan::kEven;
  std::vector<int> rates = kRates;
  double settle = 0;           // s that the scene takes to become what its cost is measured of
  bool needs_springs = false;  // which the engines alone do not have
  bool is_large = false;       // so that solving directly takes hours
};

/// All of them, in the order of the report.
std::vector<Problem> Problems();

void AddFreeBodies(std::vector<Problem>& problems);
void AddJoints(std::vector<Problem>& problems);
void AddChains(std::vector<Problem>& problems);
void AddSliding(std::vector<Problem>& problems);
void AddBounces(std::vector<Problem>& problems);
void AddCollisions(std::vector<Problem>& problems);
void AddLinkedCollisions(std::vector<Problem>& problems);
void AddSwitches(std::vector<Problem>& problems);
void AddAny(std::vector<Problem>& problems);
void AddCosts(std::vector<Problem>& problems);

}  // namespace genphys::bench

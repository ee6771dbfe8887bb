#pragma once
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "contender.h"
#include "scene.h"
#include "simulation.h"

namespace genphys::bench {

/// How far apart the ends of balls and hinges are, the farthest of them, m.
double JointGap(const Simulation& simulation, const Scene& scene);

/// How a run gets to where it goes: by equal steps, or by steps from half to one and a half times the size.
enum class StepPlan { kEven, kRandom };

/// One simulation on its way, and what can be said of it as a whole.
class Run {
 public:
  Run(std::unique_ptr<Simulation> simulation, const Scene& scene, double step_size, StepPlan plan);

  /// Steps until `time` (s since the start, a whole number of steps if they are even), and calls `after_each` step.
  void StepTo(double time, const std::function<void()>& after_each = {});

  double time() const { return time_; }
  double step_size() const { return step_size_; }
  Motion operator[](size_t body) const { return simulation_->MotionOf(body); }
  Simulation& simulation() { return *simulation_; }

  /// J, of motion and weight.
  double Energy() const;
  /// J, of motion alone.
  double KineticEnergy() const;
  Vector3 Momentum() const;         // kg*m/s
  Vector3 AngularMomentum() const;  // kg*m^2/s, about the origin
  double JointGap() const { return bench::JointGap(*simulation_, scene_); }

 private:
  double NextStep(double left);

  std::unique_ptr<Simulation> simulation_;
  Scene scene_;
  std::vector<MassProperties> masses_;  // zero: static
  double step_size_;
  StepPlan plan_;
  std::mt19937 generator_{1};
  double time_ = 0;
};

/// Starts runs of one contender with one step size.
class Lab {
 public:
  Lab(const Contender& contender, double step_size, StepPlan plan)
      : contender_(contender), step_size_(step_size), plan_(plan) {}

  Run Start(const Scene& scene) const { return Start(scene, step_size_); }
  /// For scenes that say their step size.
  Run Start(const Scene& scene, double step_size) const { return {contender_.start(scene), scene, step_size, plan_}; }
  double step_size() const { return step_size_; }

 private:
  const Contender& contender_;
  double step_size_;
  StepPlan plan_;
};

}  // namespace genphys::bench

#pragma once
#include <optional>
#include <span>
#include <vector>

#include "pairs/contact_points.h"
#include "step/step_run.h"

namespace genphys {

/// How the two of a contact go on until the end of a substep if all acts on them as it did in the last one. Velocities
/// are those from which the next solve goes on.
class StepRun::Foretold {
 public:
  Foretold(StepRun& run, double h) : run_(run), last_(run.world_.layer_.last_substep), h_(h) {}

 protected:
  std::span<const ContactPoint> PointsOf(const ContactPair& pair) const {
    return genphys::PointsOf(run_.world_.contacts_, pair);
  }
  // Whether it is known what holds both, and the next solve is for as long a time of both.
  bool IsKnown(const ContactPair& pair);
  // m/s^2, of its centre of mass.
  Vector3 RateOf(EntityRow row) const;
  // rad/s^2, the same of its turning.
  Vector3 TurnRateOf(EntityRow row) const;
  Matrix3 InverseOf(EntityRow row) const;
  // How hard each point is pressed, as a part of all; whether any is.
  bool FindShares(const ContactPair& pair);
  // The one that has but this pair, with something that nothing moves: nothing else changes how it slips or rolls.
  std::optional<EntityRow> StandingAlone(const ContactPair& pair);
  // What StandingAlone() counted.
  void ForgetPairs();

  // The sine of the angle between them, or one if it is a right angle or more.
  static double Angle(const Vector3& from, const Vector3& to);

  StepRun& run_;
  double last_, h_;  // s, the last substep and this one
  // Of the pair at hand.
  double time_ = 0;                       // s, for which the solve acts on it
  std::span<const ContactPoint> solved_;  // as they were in the last solve
  std::vector<double> pressed_;           // the part that each point bears

 private:
  bool IsKnown(EntityRow row) const;
  int PairsOf(EntityRow row);

  bool has_counted_ = false;
};

}  // namespace genphys

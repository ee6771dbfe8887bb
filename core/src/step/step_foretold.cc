#include "step/step_foretold.h"

#include <algorithm>
#include <utility>

#include "motion/free_rotation.h"

namespace genphys {

bool StepRun::Foretold::IsKnown(const ContactPair& pair) {
  time_ = run_.IntervalOf(pair, h_);
  return IsKnown(pair.entity_a) && IsKnown(pair.entity_b);
}

bool StepRun::Foretold::IsKnown(EntityRow row) const {
  if (!run_.IsMoved(row)) return true;
  const HalfStep& half = run_.world_.layer_.half_steps[Index(row)];
  return half.has_past && !half.is_struck && !half.is_woken && !half.in_flight && half.Interval(last_, h_) == time_ &&
         !run_.scratch_.jointed[row] && !run_.world_.scene_.entities[Index(row)]->traits.is_locked;
}

Vector3 StepRun::Foretold::RateOf(EntityRow row) const {
  if (!run_.IsMoved(row)) return Vector3::Zero();
  return run_.WholePush(row).acceleration + run_.world_.layer_.half_steps[Index(row)].held_rate;
}

Vector3 StepRun::Foretold::TurnRateOf(EntityRow row) const {
  if (!run_.IsMoved(row)) return Vector3::Zero();
  const Vector3 torque = run_.WholePush(row).torque + run_.world_.layer_.half_steps[Index(row)].held_torque;
  return InverseOf(row) * torque;
}

Matrix3 StepRun::Foretold::InverseOf(EntityRow row) const {
  const Matrix3& own = run_.world_.scene_.entities[Index(row)]->mass.inverse_tensor;
  return WorldTensor(run_.state_.pose(row).orientation, own);
}

bool StepRun::Foretold::FindShares(const ContactPair& pair) {
  double sum = 0;
  pressed_.clear();
  for (const ContactPoint& point : PointsOf(pair)) {
    const ContactPoint& nearest = *std::ranges::min_element(
        solved_, {}, [&](const ContactPoint& last) { return (last.position - point.position).squaredNorm(); });
    pressed_.push_back(nearest.normal_impulse);
    sum += nearest.normal_impulse;
  }
  for (double& each : pressed_) each /= sum;
  return sum > 0;
}

std::optional<EntityRow> StepRun::Foretold::StandingAlone(const ContactPair& pair) {
  if (run_.IsMoved(pair.entity_a) == run_.IsMoved(pair.entity_b)) return std::nullopt;
  const EntityRow row = run_.IsMoved(pair.entity_a) ? pair.entity_a : pair.entity_b;
  return PairsOf(row) == 1 ? std::optional(row) : std::nullopt;
}

int StepRun::Foretold::PairsOf(EntityRow row) {
  RowValues<int>& counts = run_.scratch_.struck_index;
  if (!std::exchange(has_counted_, true)) {
    for (const ContactPair& pair : run_.world_.contacts_.pairs) {
      if (!run_.Holds(pair)) continue;
      for (const EntityRow each : {pair.entity_a, pair.entity_b}) counts[each] = std::max(counts[each], 0) + 1;
    }
  }
  return std::as_const(counts)[row];
}

void StepRun::Foretold::ForgetPairs() {
  if (std::exchange(has_counted_, false)) run_.scratch_.struck_index.Clear();
}

double StepRun::Foretold::Angle(const Vector3& from, const Vector3& to) {
  const double cosine = from.dot(to);
  return cosine <= 0 ? 1 : from.cross(to).norm() / (from.norm() * to.norm());
}

}  // namespace genphys

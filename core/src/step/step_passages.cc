// Kinematic bodies: how fast those that are led to a pose go in this step, and what contacts are told of all of them.
#include <algorithm>
#include <map>
#include <vector>

#include "genphys/limits.h"
#include "motion/free_rotation.h"
#include "step/step_run.h"

namespace genphys {

std::vector<EntityId> StepRun::StartPassages() {
  std::map<EntityId, Passage>& passages = world_.layer_.passages;
  if (passages.empty()) return {};
  ++world_.changes_;
  undo_.KeepPassages();
  for (const auto& [id, passage] : passages) undo_.Keep(EntityRow{id.index()});
  std::vector<EntityId> over;
  for (auto& [id, passage] : passages) {
    if (Lead(id, passage)) over.push_back(id);
  }
  for (const EntityId id : over) {
    world_.EndPassage(id);
    world_.UpdateActive(EntityRow{id.index()});
  }
  world_.SettleAftermath();
  return over;
}

// Whether the passage is over. It is what is left of the way in what is left of the steps, so that steps of unequal
// size and the rounding of earlier ones lead to the pose as well.
bool StepRun::Lead(EntityId id, Passage& passage) {
  const EntityRow row{id.index()};
  const Pose here = state_.pose(row);
  const double time = step_size_ * passage.steps_left;
  Vector3 linear = Vector3::Zero(), angular = Vector3::Zero();
  if (passage.steps_left > 0) {
    linear = (passage.target.position - here.position) / time;
    angular = TurnBetween(here.orientation, passage.target.orientation) / time;
  }
  const bool is_too_fast = linear.norm() > Limits::kSpeedMax || angular.norm() > Limits::kSpinMax;
  if (is_too_fast) {
    linear = angular = Vector3::Zero();
    world_.SetPoseNow({id, passage.target.position, passage.target.orientation});
  }
  state_.linear_velocities.col(Index(row)) = linear;
  state_.angular_velocities.col(Index(row)) = angular;
  world_.Unsettle(row);
  world_.TellPose(row);
  if (is_too_fast || passage.steps_left == 0) return true;
  --passage.steps_left;
  return false;
}

// A solve is told how surfaces slip at the boundary, the middle of the time that it is for. What is led shows how it
// went in the middle of the last substep until then, and from then on how it goes in that of the next one: in between
// it slips as on their mean. Velocities are those at the boundary, but for what is led.
void StepRun::FillLedSlips(double h) {
  if (courses_.AreEven()) return;
  const auto begins_anew = [&](EntityRow row) { return IsMoved(row) && world_.layer_.half_steps[Index(row)].restarts; };
  for (const ContactPair& pair : world_.contacts_.pairs) {
    if (IsMoved(pair.entity_a) && IsMoved(pair.entity_b)) continue;
    // Who begins anew at the boundary finds what jumps there as it goes from then on.
    const bool is_anew = begins_anew(pair.entity_a) || begins_anew(pair.entity_b);
    const bool jumps = is_first_ && !is_anew;
    const Courses::Faster a = courses_.ChangeOf(pair.entity_a, h, jumps),
                          b = courses_.ChangeOf(pair.entity_b, h, jumps);
    if (a.is_zero() && b.is_zero()) continue;
    const Vector3 center_a = CenterOf(pair.entity_a), center_b = CenterOf(pair.entity_b);
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      ContactPoint& point = world_.contacts_.points[i];
      const auto velocity = [&](EntityRow row, const Vector3& center, const Courses::Faster& faster) -> Vector3 {
        const Vector3 earlier = faster.linear + faster.angular.cross(point.position - center);
        return VelocityAt(row, center, point.position) - earlier / 2;
      };
      const Vector3 change =
          velocity(pair.entity_b, center_b, b) - velocity(pair.entity_a, center_a, a) - point.relative_velocity;
      point.relative_velocity += change - change.dot(point.normal) * point.normal;
    }
  }
}

}  // namespace genphys

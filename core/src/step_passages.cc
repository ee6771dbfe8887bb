// Kinematic bodies that are led to a pose: how fast they go in this step.
#include <map>
#include <vector>

#include "free_rotation.h"
#include "genphys/limits.h"
#include "step_run.h"

namespace genphys {

std::vector<EntityId> StepRun::StartPassages() {
  std::map<EntityId, Passage>& passages = world_.layer_.passages;
  if (passages.empty()) return {};
  ++world_.changes_;
  world_.is_settled_ = false;
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
  world_.TellPose(row);
  if (is_too_fast || passage.steps_left == 0) return true;
  --passage.steps_left;
  return false;
}

}  // namespace genphys

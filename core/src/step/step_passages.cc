// Kinematic bodies: how fast those that are led to a pose go in this step, and how all of them go within it.
#include <algorithm>
#include <map>
#include <vector>

#include "genphys/limits.h"
#include "motion/free_rotation.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// Of the larger of two accelerations: from one step to the next those of a smooth course differ by less.
constexpr double kSmooth = 0.5;

// Whether a course with these accelerations is smooth.
bool IsSmooth(const Vector3& before, const Vector3& now) {
  return !now.isZero(0) &&
         (now - before).squaredNorm() <= kSmooth * kSmooth * std::max(now.squaredNorm(), before.squaredNorm());
}

}  // namespace

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

// Who tells a velocity, or a pose, for each step means a course on which that is the mean of the step. With it from the
// first substep on, what lies on that would have to get all the change of a step in one of its substeps. So where the
// last steps tell how it goes on, velocities go straight through the step, to the same pose at its end; what changes
// otherwise is a jump, and goes evenly.
void StepRun::FindCourses() {
  courses_.clear();
  const double last = world_.layer_.last_substep / substep_ * step_size_;
  for (const EntityRow row : kinematic_rows_) {
    const uint32_t column = Index(row);
    Course& course = courses_.emplace_back();
    course.row = row;
    course.linear = state_.linear_velocities.col(column);
    course.angular = state_.angular_velocities.col(column);
    HalfStep& half = world_.layer_.half_steps[column];
    const double interval = (last + step_size_) / 2;
    // What it keeps is of no contacts, which do not move it, but of how it was led. Who was not stood still.
    const Vector3 rate = (half.has_past ? Vector3(course.linear - half.velocity) : course.linear) / interval;
    const Vector3 turn_rate = (half.has_past ? Vector3(course.angular - half.momentum) : course.angular) / interval;
    const Vector3 gain = step_size_ * rate, twist = step_size_ * turn_rate;
    const bool fits = course.linear.norm() + gain.norm() < Limits::kSpeedMax &&
                      course.angular.norm() + twist.norm() < Limits::kSpinMax;
    if (fits && IsSmooth(half.held_rate, rate)) course.gain = gain;
    if (fits && IsSmooth(half.held_torque, turn_rate)) course.twist = twist;
    half.held_rate = rate;
    half.held_torque = turn_rate;
  }
}

bool StepRun::ChangesCourse(EntityRow row) const {
  const auto course = std::ranges::lower_bound(courses_, row, {}, &Course::row);
  return course != courses_.end() && course->row == row && !(course->gain.isZero(0) && course->twist.isZero(0));
}

// Up to what `part` of the step the middle of the next substep is.
void StepRun::FollowCourses(double part) {
  for (const Course& course : courses_) {
    if (world_.layer_.faulted[Index(course.row)]) continue;
    state_.linear_velocities.col(Index(course.row)) = course.linear + (part - 0.5) * course.gain;
    state_.angular_velocities.col(Index(course.row)) = course.angular + (part - 0.5) * course.twist;
    if (!course.gain.isZero(0) || !course.twist.isZero(0)) world_.engine_->WriteState({&course.row, 1}, state_);
  }
}

// Shows what was told, and remembers it.
void StepRun::EndCourses() {
  FollowCourses(0.5);
  for (const Course& course : courses_) {
    if (world_.layer_.faulted[Index(course.row)]) continue;
    NoteLed(course.row);
    world_.layer_.half_steps[Index(course.row)].has_past = true;
  }
}

}  // namespace genphys

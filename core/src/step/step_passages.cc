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
    if (half.has_past) {
      course.jump = course.linear - half.velocity;
      course.twist_jump = course.angular - half.momentum;
    }
    half.held_rate = rate;
    half.held_torque = turn_rate;
  }
}

StepRun::Faster StepRun::LedFaster(EntityRow row, double h, bool is_smooth) const {
  const auto course = std::ranges::lower_bound(courses_, row, {}, &Course::row);
  if (course == courses_.end() || course->row != row) return {};
  const auto faster = [&](const Vector3& gain, const Vector3& jump) -> Vector3 {
    if (!gain.isZero(0)) return h / step_size_ * gain;
    return is_first_ && !is_smooth ? jump : Vector3(Vector3::Zero());
  };
  return {faster(course->gain, course->jump), faster(course->twist, course->twist_jump)};
}

// A solve is told how surfaces slip at the boundary, the middle of the time that it is for. What is led shows how it
// went in the middle of the last substep until then, and from then on how it goes in that of the next one: in between
// it slips as on their mean. Velocities are those at the boundary, but for what is led.
void StepRun::FillLedSlips(double h) {
  const auto is_even = [](const Course& course) {
    return course.gain.isZero(0) && course.twist.isZero(0) && course.jump.isZero(0) && course.twist_jump.isZero(0);
  };
  if (std::ranges::all_of(courses_, is_even)) return;
  const auto begins_anew = [&](EntityRow row) { return IsMoved(row) && world_.layer_.half_steps[Index(row)].restarts; };
  for (const ContactPair& pair : world_.contacts_.pairs) {
    if (IsMoved(pair.entity_a) && IsMoved(pair.entity_b)) continue;
    // Who begins anew at the boundary finds what jumps there as it goes from then on.
    const bool is_anew = begins_anew(pair.entity_a) || begins_anew(pair.entity_b);
    const Faster a = LedFaster(pair.entity_a, h, is_anew), b = LedFaster(pair.entity_b, h, is_anew);
    if (a.linear.isZero(0) && a.angular.isZero(0) && b.linear.isZero(0) && b.angular.isZero(0)) continue;
    const Vector3 center_a = CenterOf(pair.entity_a), center_b = CenterOf(pair.entity_b);
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      ContactPoint& point = world_.contacts_.points[i];
      const auto velocity = [&](EntityRow row, const Vector3& center, const Faster& faster) -> Vector3 {
        const Vector3 earlier = faster.linear + faster.angular.cross(point.position - center);
        return VelocityAt(row, center, point.position) - earlier / 2;
      };
      const Vector3 change =
          velocity(pair.entity_b, center_b, b) - velocity(pair.entity_a, center_a, a) - point.relative_velocity;
      point.relative_velocity += change - change.dot(point.normal) * point.normal;
    }
  }
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

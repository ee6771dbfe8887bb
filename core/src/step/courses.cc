#include "step/courses.h"

#include <algorithm>

#include "genphys/limits.h"

namespace genphys {
namespace {

// Of the larger of two accelerations: from one step to the next those of a smooth course differ by less.
constexpr double kSmooth = 0.5;

// Whether a course with these accelerations is smooth.
bool IsSmooth(const Vector3& before, const Vector3& now) {
  return !now.isZero(0) &&
         (now - before).squaredNorm() <= kSmooth * kSmooth * std::max(now.squaredNorm(), before.squaredNorm());
}

// Of the larger of two velocities: who is led changes by more at once, or goes on much as before.
constexpr double kJump = 0.5;

bool IsJump(const Vector3& before, const Vector3& after) {
  return (after - before).norm() > kJump * std::max(before.norm(), after.norm());
}

void ForgetCourse(HalfStep& half) {
  half.has_past = false;
  for (Vector3* of : {&half.velocity, &half.momentum, &half.held_rate, &half.held_torque}) of->setZero();
}

}  // namespace

void Courses::Find(std::span<const EntityRow> rows) {
  courses_.clear();
  for (const EntityRow row : rows) {
    const uint32_t column = Index(row);
    Course& course = courses_.emplace_back();
    course.row = row;
    course.linear = state_.linear_velocities.col(column);
    course.angular = state_.angular_velocities.col(column);
    HalfStep& half = layer_.half_steps[column];
    if (!WasLed(half)) ForgetCourse(half);
    const double interval = (layer_.last_step + step_size_) / 2;
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

bool Courses::Course::IsEven() const {
  return gain.isZero(0) && twist.isZero(0) && jump.isZero(0) && twist_jump.isZero(0);
}

bool Courses::AreEven() const { return std::ranges::all_of(courses_, &Course::IsEven); }

std::vector<EntityRow> Courses::Uneven() const {
  std::vector<EntityRow> rows;
  for (const Course& course : courses_) {
    if (!course.IsEven()) rows.push_back(course.row);
  }
  return rows;
}

Courses::Faster Courses::ChangeOf(EntityRow row, double h, bool jumps) const {
  const auto course = std::ranges::lower_bound(courses_, row, {}, &Course::row);
  if (course == courses_.end() || course->row != row) return {};
  const auto faster = [&](const Vector3& gain, const Vector3& jump) -> Vector3 {
    if (!gain.isZero(0)) return h / step_size_ * gain;
    return jumps ? jump : Vector3(Vector3::Zero());
  };
  return {faster(course->gain, course->jump), faster(course->twist, course->twist_jump)};
}

void Courses::Follow(double part, BackendWorld& engine) {
  for (const Course& course : courses_) {
    if (layer_.faulted[Index(course.row)]) continue;
    state_.linear_velocities.col(Index(course.row)) = course.linear + (part - 0.5) * course.gain;
    state_.angular_velocities.col(Index(course.row)) = course.angular + (part - 0.5) * course.twist;
    if (!course.gain.isZero(0) || !course.twist.isZero(0)) engine.WriteState({&course.row, 1}, state_);
  }
}

void Courses::End(BackendWorld& engine) {
  Follow(0.5, engine);
  for (const Course& course : courses_) {
    if (layer_.faulted[Index(course.row)]) continue;
    HalfStep& half = layer_.half_steps[Index(course.row)];
    half.velocity = course.linear;
    half.momentum = course.angular;
    half.has_past = true;
    half.last_led = layer_.step + 1;
  }
}

bool Courses::IsLedOtherwise(EntityRow row) const {
  const HalfStep& last = layer_.half_steps[Index(row)];
  const Vector3 linear = state_.linear_velocities.col(Index(row)), angular = state_.angular_velocities.col(Index(row));
  if (!WasLed(last)) return !linear.isZero(0) || !angular.isZero(0);
  return IsJump(last.velocity, linear) || IsJump(last.momentum, angular);
}

// Who was not stood still in the last step, however it went before.
bool Courses::WasLed(const HalfStep& half) const { return half.has_past && half.last_led == layer_.step; }

}  // namespace genphys

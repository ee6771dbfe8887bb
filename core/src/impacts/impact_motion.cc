#include "impacts/impact_motion.h"

#include <limits>
#include <numbers>

#include "motion/free_rotation.h"

namespace genphys {
namespace {

// On the way to an impact a body is asked for its pose many times. So many inner steps are accurate up to a turn of
// fifteen radians, and of two and a half about the axis of a slender body; what turns by more than 64 takes more of
// them.
constexpr int kInnerStepsOfWay = 128;

// Where a free body turns in `time`, which may be negative: with the opposite momentum it goes back the way it came.
Quaternion TurnedFreely(const Quaternion& orientation, const Vector3& momentum, const MassProperties& mass,
                        double time) {
  if (time == 0) return orientation;
  const Vector3 forward = time < 0 ? Vector3(-momentum) : momentum;
  const double length = std::abs(time);
  return Turned(orientation, MeanFreeSpin(orientation, forward, mass.inverse_tensor, length, kInnerStepsOfWay), length);
}

}  // namespace

ImpactMotion ImpactMotion::Driven(const Pose& pose, const Vector3& linear_velocity, const Vector3& angular_velocity) {
  ImpactMotion motion;
  motion.pose_ = pose;
  motion.linear_velocity_ = linear_velocity;
  motion.momentum_ = angular_velocity;
  return motion;
}

ImpactMotion ImpactMotion::Free(const Pose& pose, const MassProperties& mass, const Vector3& linear_velocity,
                                const Vector3& angular_velocity, const Vector3& acceleration) {
  ImpactMotion motion = Driven(pose, linear_velocity, WorldTensor(pose.orientation, mass.tensor) * angular_velocity);
  motion.known_ = pose.orientation;
  motion.mass_ = &mass;
  motion.acceleration_ = acceleration;
  return motion;
}

ImpactMotion ImpactMotion::Along(const Pose& start, double time, const Pose& pose, const MassProperties& mass,
                                 const Vector3& linear_velocity, const Vector3& angular_velocity,
                                 const Vector3& acceleration, const Vector3& torque) {
  ImpactMotion motion = Free(pose, mass, linear_velocity, angular_velocity, acceleration);
  motion.is_led_ = true;
  motion.is_pushed_on_ = false;
  if (!(time > 0)) return motion;
  motion.torque_ = torque;
  const Vector3 way = pose.Transform(mass.center_of_mass) - start.Transform(mass.center_of_mass);
  motion.way_ = way / time + time / 2 * acceleration;
  const Vector3 momentum = motion.momentum_ - time * torque;
  motion.turning_ = (angular_velocity - WorldTensor(start.orientation, mass.inverse_tensor) * momentum) / time;
  const Vector3 turn = TurnBetween(start.orientation, pose.orientation, time * angular_velocity);
  motion.turn_ = turn / time + time / 2 * motion.turning_;
  return motion;
}

Vector3 ImpactMotion::CenterAt(const Pose& pose) const {
  return mass_ != nullptr ? pose.Transform(mass_->center_of_mass) : pose.position;
}

Vector3 ImpactMotion::CenterBefore(double time) const {
  return CenterAt(pose_) - time * (is_led_ ? way_ : linear_velocity_) + time * time / 2 * acceleration_;
}

Pose ImpactMotion::PoseBefore(double time) const {
  if (time == 0) return pose_;
  const Vector3 center = CenterBefore(time);
  if (mass_ == nullptr) return {center, Turned(pose_.orientation, -momentum_, time)};
  const Quaternion orientation = is_led_ ? Turned(pose_.orientation, time / 2 * turning_ - turn_, time)
                                         : TurnedFreely(known_, momentum_, *mass_, known_time_ - time);
  return {center - orientation * mass_->center_of_mass, orientation};
}

// What is accelerated by no more than a leaves a chord that takes it the time t by no more than a t^2 / 8.
double ImpactMotion::BowMax(double time, double reach) const {
  double spin = 0, turning = 0;  // rad/s and rad/s^2, at most
  if (is_led_) {
    spin = turn_.norm() + time * turning_.norm();
    turning = turning_.norm() + spin * spin;
  } else {
    spin = angular_velocity().norm();
    if (mass_ != nullptr) {
      // Of three moments two differ by no more than the third one: the spin w of a free body changes by no more than
      // w^2 / sqrt(3).
      const double left = 1 - time * spin / std::numbers::sqrt3;
      if (left <= 0) return std::numeric_limits<double>::infinity();
      spin /= left;
      turning = spin * spin / std::numbers::sqrt3;
    }
  }
  return time * time / 8 * (acceleration_.norm() + reach * (spin * spin + turning));
}

void ImpactMotion::GoFrom(double time) {
  known_ = PoseBefore(time).orientation;
  known_time_ = time;
}

StruckBody ImpactMotion::BodyBefore(double time) const {
  const Pose pose = PoseBefore(time);
  StruckBody body;
  body.center = CenterAt(pose);
  body.linear_velocity = linear_velocity_ - time * acceleration_;
  body.angular_velocity = momentum_;
  if (mass_ == nullptr) return body;
  body.inverse_mass = 1 / mass_->mass;
  body.tensor = WorldTensor(pose.orientation, mass_->tensor);
  body.inverse_tensor = WorldTensor(pose.orientation, mass_->inverse_tensor);
  body.angular_velocity = body.inverse_tensor * (momentum_ - time * torque_);
  return body;
}

StruckBody ImpactMotion::Coast(const StruckBody& struck, double time) const {
  StruckBody body = struck;
  if (is_pushed_on_) body.linear_velocity += time * acceleration_;
  return body;
}

ImpactMotion ImpactMotion::After(double time, const StruckBody& struck, const StruckBody& end) const {
  ImpactMotion after = *this;
  after.linear_velocity_ = end.linear_velocity;
  after.momentum_ = struck.tensor * end.angular_velocity;
  if (time == 0) return after;
  const Quaternion before = PoseBefore(time).orientation;
  const Vector3 mean = (struck.linear_velocity + end.linear_velocity) / 2;
  const Vector3 momentum = struck.tensor * (struck.angular_velocity + end.angular_velocity) / 2;
  after.known_ = TurnedFreely(before, momentum, *mass_, time);
  after.known_time_ = 0;
  after.pose_ = {struck.center + time * mean - after.known_ * mass_->center_of_mass, after.known_};
  return after;
}

Vector3 ImpactMotion::angular_velocity() const {
  return mass_ == nullptr ? momentum_ : Vector3(WorldTensor(pose_.orientation, mass_->inverse_tensor) * momentum_);
}

}  // namespace genphys

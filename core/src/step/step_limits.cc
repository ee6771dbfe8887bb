// How what joints stop at their limits within a substep goes on from there.
#include <algorithm>
#include <cmath>
#include <vector>

#include "motion/free_rotation.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// Of a substep: for so long it is looked what media take of a velocity.
constexpr double kGlance = 1e-3;
// Of which damping leaves less than exp() of this with a minus until the end, the velocity of the middle is not told by
// that of the end.
constexpr double kMuchTaken = 1;

}  // namespace

void StepRun::LeaveLimits(double h) {
  const auto push_of = [&](EntityRow row, const Vector3& velocity, const Vector3& momentum) {
    return BrakedPush(row, h, velocity, momentum);
  };
  std::vector<JointStep::Led> led;
  for (const JointStep::Change& change : joints_.LeaveReached(h, push_of, led)) {
    const uint32_t row = Index(change.row);
    HalfStep& half = world_.layer_.half_steps[row];
    state_.linear_velocities.col(row) += change.linear;
    state_.angular_velocities.col(row) += change.angular;
    half.velocity += change.linear;
    const MassProperties& mass = world_.scene_.entities[row]->mass;
    half.momentum += WorldTensor(state_.pose(change.row).orientation, mass.tensor) * change.angular;
    // The limit bears from now on what it did not in the middle of the substep.
    if (change.is_pressed) half.Restart();
  }
  std::vector<EntityRow> moved;
  for (const JointStep::Led& each : led) {
    Lead(each, h);
    moved.push_back(each.row);
  }
  if (!moved.empty()) world_.engine_->WriteState(moved, state_);
}

// With what media do to it, which goes by how fast it is.
Push StepRun::BrakedPush(EntityRow row, double h, const Vector3& velocity, const Vector3& momentum) const {
  const double glance = kGlance * h;
  const Matrix3& own = world_.scene_.entities[Index(row)]->mass.inverse_tensor;
  const Matrix3 inverse = WorldTensor(state_.pose(row).orientation, own);
  const Motion slowed = fields_.ResistanceOf(row, inverse).Slowed(glance, {velocity, momentum}, {}, {});
  Push push = WholePush(row);
  push.acceleration += (slowed.linear - velocity) / glance;
  push.torque += (slowed.momentum - momentum) / glance;
  return push;
}

// As if what holds it since then had done so in all of the substep.
void StepRun::Lead(const JointStep::Led& led, double h) {
  const uint32_t row = Index(led.row);
  HalfStep& half = world_.layer_.half_steps[row];
  const auto& [id, desc, mass, traits] = *world_.scene_.entities[row];
  const Matrix3 tensor = WorldTensor(state_.pose(led.row).orientation, mass.tensor);
  const Vector3 momentum = tensor * state_.angular_velocities.col(row), velocity = state_.linear_velocities.col(row);
  const Vector3 held_velocity = h / 2 * led.held_rate, held_momentum = h / 2 * led.held_torque;
  const double taken = traits.linear_damping * h / 2, taken_of_spin = traits.angular_damping * h / 2;
  const Vector3 gained = (led.linear_velocity - velocity) - MeanLeft(taken) * (held_velocity - half.held_velocity);
  const Vector3 turned = (led.momentum - momentum) - MeanLeft(taken_of_spin) * (held_momentum - half.held_momentum);
  half.velocity += std::exp(std::min(taken, kMuchTaken)) * gained;
  half.momentum += std::exp(std::min(taken_of_spin, kMuchTaken)) * turned;
  half.held_velocity = held_velocity;
  half.held_momentum = held_momentum;
  half.held_rate = led.held_rate;
  half.held_torque = led.held_torque;
  state_.set_pose(led.row, led.pose);
  state_.linear_velocities.col(row) = led.linear_velocity;
  const Matrix3 inverse = WorldTensor(led.pose.orientation, mass.inverse_tensor);
  state_.angular_velocities.col(row) = inverse * led.momentum;
  // How fast it would have been is not told where media slow it down.
  if (std::max(taken, taken_of_spin) > kMuchTaken || fields_.IsInMedium(led.row)) half.Restart();
}

}  // namespace genphys

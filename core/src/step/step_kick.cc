// How forces act in a substep: the leapfrog of every body, around the solve of its contacts and joints.
#include <algorithm>
#include <cmath>
#include <utility>

#include "genphys/limits.h"
#include "motion/free_rotation.h"
#include "motion/locked_axes.h"
#include "motion/resistance.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// s, for which it counts how much energy a body that joints turn lately had. With 1 s, or with half of kUnearnedPart,
// random pendulums of three links that swing for 5 s at 240 steps per second lose a tenth, or a third, more by what is
// taken from them.
constexpr double kPeakFades = 10;
// Accelerations that differ by less than this part of the larger one are the same.
constexpr double kSameForce = 1e-12;
// What contacts and joints give changed by this part of the larger value, and is this many times what acts from
// outside: a blow, and no part of a smooth course that could be carried on.
constexpr double kBlowChange = 0.5;
constexpr double kBlowSize = 1.5;
// m/s: a smaller one is rounding. What only turns is held by nothing else, and by another nothing in each substep.
constexpr double kLeastBlow = 1e-9;

// The part of a velocity that is no more than what rounding leaves of it.
constexpr double kRounding = 1e-12;
// m/s^2: what is pushed no more than that, or than by that part of gravity, is held where it is by what pushes it.
constexpr double kNoPush = 1e-6;
constexpr double kBalanced = 1e-3;

Vector3 Limited(const Vector3& velocity, double speed_max) {
  // Most have no limit at all, and need no root.
  if (!(velocity.squaredNorm() > speed_max * speed_max)) return velocity;
  return velocity * (speed_max / velocity.norm());
}

bool IsSame(const Vector3& a, const Vector3& b) {
  return (a - b).squaredNorm() <= kSameForce * kSameForce * std::max(a.squaredNorm(), b.squaredNorm());
}

// `interval`: s for which it was held by `rate`, and `before` that by another.
bool IsBlow(const Vector3& rate, const Vector3& before, const Vector3& outside, double interval) {
  const double square = rate.squaredNorm(), change = (rate - before).squaredNorm();
  return square > kBlowSize * kBlowSize * outside.squaredNorm() &&
         change > kBlowChange * kBlowChange * std::max(square, before.squaredNorm()) &&
         change * interval * interval > kLeastBlow * kLeastBlow;
}

// What holds a body that is followed through its turn turns with it, and goes on to change as it did, unless that was
// more than turning explains. `ahead` is the time to come as a part of that in which it changed from what was before.
Vector3 GoneOn(const Vector3& now, const Vector3& before, double ahead) {
  const Vector3 change = now - before;
  if (ahead == 0 || change.squaredNorm() > kResolvedTurn * kResolvedTurn * now.squaredNorm()) return now;
  return now + ahead * change;
}

}  // namespace

// About the centre of mass, in world coordinates.
Wrench StepRun::WrenchOf(const PendingForce& pending) const {
  const EntityRow row{pending.id.index()};
  const Pose pose = state_.pose(row);
  const bool own = pending.coordinates == Coordinates::kEntity;
  Wrench sum;
  sum.force = own ? Vector3(pose.orientation * pending.force) : pending.force;
  sum.torque += own ? Vector3(pose.orientation * pending.torque) : pending.torque;
  if (pending.at_center_of_mass) return sum;
  const Vector3& center = world_.scene_.entities[Index(row)]->mass.center_of_mass;
  sum.torque += (pose.orientation * (pending.point - center)).cross(sum.force);
  return sum;
}

void StepRun::GatherForces() {
  scratch_.wrenches.Clear();
  for (const PendingForce& pending : world_.layer_.forces) {
    if (pending.is_sampled) continue;
    const Wrench wrench = WrenchOf(pending);
    Wrench& sum = scratch_.wrenches[EntityRow{pending.id.index()}];
    sum.force += wrench.force;
    sum.torque += wrench.torque;
  }
}

// Samples are those of the boundary at which the step begins, and stay the same through it.
void StepRun::GatherSamples() {
  for (const PendingForce& pending : world_.layer_.forces) {
    if (!pending.is_sampled) continue;
    const EntityRow row{pending.id.index()};
    const Wrench wrench = WrenchOf(pending);
    Wrench& sum = scratch_.samples[row];
    sum.force += wrench.force;
    sum.torque += wrench.torque;
    scratch_.is_sampled.Mark(row);
  }
  for (const SampledForce& last : world_.layer_.samples) {
    const EntityRow row{last.id.index()};
    if (state_.ids[Index(row)] != last.id) continue;
    scratch_.last_samples[row] = {last.force, last.torque};
    scratch_.was_sampled.Mark(row);
  }
}

// Adds what is sampled to what acts in this substep, and returns what the last step gets of it afterwards (m/s and
// N*m*s): there the force went straight from its sample to this one, which was not known then (velocity Verlet: Swope
// et al., J. Chem. Phys. 76, 1982). What is paid anyway of the last substep is counted in.
Push StepRun::AddSample(Mover& mover) const {
  const bool is_sampled = scratch_.is_sampled[mover.row], was_sampled = scratch_.was_sampled[mover.row];
  if (!is_sampled && !was_sampled) return {};
  const double mass = world_.scene_.entities[Index(mover.row)]->mass.mass;
  const Wrench &now = std::as_const(scratch_.samples)[mover.row],
               &last = std::as_const(scratch_.last_samples)[mover.row];
  mover.field.acceleration += now.force / mass;
  mover.field.torque += now.torque;
  if (!is_first_) return {};
  const double time = (is_sampled && was_sampled ? world_.layer_.samples_step / 2 : 0) - mover.past;
  return {time / mass * (now.force - last.force), time * (now.torque - last.torque)};
}

void StepRun::GatherFields(double h) {
  scratch_.field_wrenches.Clear();
  if (!fields_.empty()) fields_.Add(rows_, h, scratch_.field_wrenches);
}

// Gravity and the forces of commands, which are known wherever the body is.
Push StepRun::SteadyPush(EntityRow row) const {
  const SceneEntity& entity = *world_.scene_.entities[Index(row)];
  Push push{entity.traits.gravity_scale * world_.scene_.world.gravity, Vector3::Zero()};
  if (scratch_.wrenches.empty()) return push;
  const Wrench& wrench = std::as_const(scratch_.wrenches)[row];
  push.acceleration += wrench.force / entity.mass.mass;
  push.torque = wrench.torque;
  return push;
}

// Of force fields, where they were last looked at.
Push StepRun::FieldPush(EntityRow row) const {
  if (scratch_.field_wrenches.empty()) return {};
  const Wrench& wrench = std::as_const(scratch_.field_wrenches)[row];
  return {wrench.force / world_.scene_.entities[Index(row)]->mass.mass, wrench.torque};
}

// What acts on it from outside, and whether that begins it anew, or something else did: a blow, or how it is made.
void StepRun::TakeSteady(Mover& mover) {
  mover.steady = SteadyPush(mover.row);
  HalfStep& half = world_.layer_.half_steps[Index(mover.row)];
  mover.beginning = Beginning::kNone;
  mover.goes_on = false;
  const double last = world_.layer_.last_substep;
  if (last == 0) return;
  if (half.restarts) mover.beginning = Beginning::kMay;
  // What changed for one of a group changes what joints give all of them.
  if (half.restarts && half.has_past && scratch_.jointed[mover.row]) mover.beginning = Beginning::kMust;
  if (half.restarts) return;
  mover.goes_on = joints_.IsDrivenOtherwise(mover.row);
  if (half.in_flight) return;
  if (IsSame(mover.steady.acceleration, half.steady_kick * (2 / last)) &&
      IsSame(mover.steady.torque, half.steady_twist * (2 / last))) {
    return;
  }
  half.is_drawn = true;
  // What joints hold goes on: a solve acts from the middle of the last substep to that of the next one, as what acts
  // from outside does, which is exact for the jump in between. What joints owe is known to first order only: paid
  // every few substeps it would add up.
  if (scratch_.jointed[mover.row]) {
    mover.goes_on = true;
    return;
  }
  // Who is pulled off what held it lets go of it for good.
  const bool lets_go = mover.steady.acceleration.dot(half.held_rate) > 0;
  mover.beginning = lets_go ? Beginning::kMust : Beginning::kMay;
}

void StepRun::BeginMovers() {
  for (Mover& mover : movers_) TakeSteady(mover);
  RestartTogether();
  RowMarks& anew = scratch_.paid;
  anew.Clear();
  for (const Mover& mover : movers_) anew.Set(mover.row, world_.layer_.half_steps[Index(mover.row)].restarts);
  PayAcross(anew);
  for (Mover& mover : movers_) BeginMover(mover);
}

// From the boundary back to the middle of the last substep.
void StepRun::BeginMover(Mover& mover) {
  const uint32_t row = Index(mover.row);
  HalfStep& half = world_.layer_.half_steps[row];
  TakeTensors(mover);
  joints_.SetTensors(mover.row, mover.turned);
  mover.start = state_.pose(mover.row);
  if (half.restarts) {
    half.since_restart = 0;
    half.steady_kick.setZero();
    half.steady_twist.setZero();
    mover.past = 0;
    mover.momentum = mover.turned.tensor * state_.angular_velocities.col(row);
    return;
  }
  mover.past = world_.layer_.last_substep / 2;
  mover.momentum = half.momentum;
  state_.linear_velocities.col(row) = half.velocity;
  state_.angular_velocities.col(row) = mover.turned.inverse * mover.momentum;
}

// Its tensors at the present pose.
void StepRun::TakeTensors(Mover& mover) const {
  const Column4 orientation = state_.orientations.col(Index(mover.row));
  TurnedTensors& turned = mover.turned;
  if (orientation == turned.turned_as) return;
  const MassProperties& mass = world_.scene_.entities[Index(mover.row)]->mass;
  turned.turned_as = orientation;
  turned.axes = FromColumn(orientation).toRotationMatrix();
  turned.tensor = WorldTensor(turned.axes, mass.tensor);
  turned.inverse = WorldTensor(turned.axes, mass.inverse_tensor);
}

void StepRun::KickMover(Mover& mover, double h) {
  // All that turns it must find the same tensor, or forces would not balance.
  const JointBody* const held = joints_.Find(mover.row);
  mover.yield = held != nullptr ? 1 / held->factor : 1;
  const uint32_t row = Index(mover.row);
  const auto& [id, desc, mass, traits] = *world_.scene_.entities[row];
  mover.field = mover.pull = FieldPush(mover.row);
  const Push late = AddSample(mover);
  // Up to the boundary by what is owed, and on to the middle of this substep by what acts now.
  const HalfStep& half = world_.layer_.half_steps[row];
  const Vector3 forward = h / 2 * (mover.steady.torque + mover.field.torque);
  mover.twist = half.steady_twist + mover.past * mover.field.torque + late.torque + forward;
  const Vector3 pushed = half.steady_kick + mover.past * mover.field.acceleration + late.acceleration +
                         h / 2 * (mover.steady.acceleration + mover.field.acceleration);
  // What holds it gives as much more for the time to come as that is longer than the time it was owed for.
  const double time = mover.past + h / 2, times = mover.past > 0 ? time / mover.past : 0;
  const std::optional<Resistance> resistance = ResistanceOf(mover);
  const Motion motion =
      Slowed(resistance, time, {state_.linear_velocities.col(row), mover.momentum}, {pushed, mover.yield * mover.twist},
             {times * half.held_velocity, times * half.held_momentum});
  mover.momentum = motion.momentum;
  mover.linear_given = Limited(motion.linear, traits.linear_speed_max);
  state_.linear_velocities.col(row) = mover.linear_given;

  Vector3 spin = mover.turned.inverse * mover.momentum;
  const double spin_most =
      held != nullptr ? std::min(traits.angular_speed_max, held->spin_most) : traits.angular_speed_max;
  if (spin.squaredNorm() > spin_most * spin_most) {
    spin = Limited(spin, spin_most);
    mover.momentum = mover.turned.tensor * spin;
  }
  // Whom joints hold while it turns so far does not go as a free body would.
  const double spin_square = spin.squaredNorm();
  const bool is_wide = scratch_.jointed[mover.row] && spin_square * (h * h) > kResolvedTurn * kResolvedTurn;
  const bool is_slow = spin_square <= Limits::kSpinMax * Limits::kSpinMax;
  const bool uniform = mass.spherical || is_wide || !is_slow;
  const Quaternion orientation = state_.pose(mover.row).orientation;
  // What contacts, joints or locks hold is turned by more than what acts from outside.
  const bool is_driven = half.in_flight && is_slow && held == nullptr && !traits.is_locked && !forward.isZero(0);
  const auto torque = [&] { return TorqueOn(resistance, mover.momentum, forward, h); };
  mover.spin_given = is_driven ? MeanDrivenSpin(orientation, mover.momentum, torque(), mass.inverse_tensor, h)
                     : uniform ? spin
                               : MeanFreeSpin(orientation, spin, mover.momentum, mass.inverse_tensor, h);
  if (resistance) mover.spin_given = resistance->MeanSpin(h, spin, mover.spin_given);
  state_.angular_velocities.col(row) = mover.spin_given;
  if (held == nullptr) return;
  const Vector3 turning = mover.past > 0 ? Vector3(mover.spin_given - spin) : Vector3::Zero();
  joints_.Kick(mover.row, mover.yield * (mover.turned.inverse * mover.twist), turning, mover.momentum, mover.goes_on);
}

// All that resists it where it is now, if anything does.
std::optional<Resistance> StepRun::ResistanceOf(const Mover& mover) const {
  const BodyTraits& traits = world_.scene_.entities[Index(mover.row)]->traits;
  if (traits.linear_damping == 0 && traits.angular_damping == 0 && fields_.empty()) return std::nullopt;
  const Resistance resistance = fields_.ResistanceOf(mover.row, mover.turned.inverse);
  return resistance.empty() ? std::nullopt : std::optional(resistance);
}

// How it goes once pushes and what resists it acted for `time`. `given`: by what holds it, which is not counted in.
Motion StepRun::Slowed(const std::optional<Resistance>& resistance, double time, const Motion& before,
                       const Motion& pushed, const Motion& given) {
  if (resistance) return resistance->Slowed(time, before, pushed, given);
  return {before.linear + pushed.linear, before.momentum + pushed.momentum};
}

// Of what turns a body in the substep, by `twist` (N*m*s) in half of it, with what resists that if it is much. In
// balance nothing is left, and a push alone would give what is small in a thick medium a speed that it never has.
Vector3 StepRun::TorqueOn(const std::optional<Resistance>& resistance, const Vector3& momentum, const Vector3& twist,
                          double h) {
  if (!resistance || !resistance->StopsTurning(h)) return 2 / h * twist;
  const Motion after = resistance->Slowed(h / 4, {Vector3::Zero(), momentum}, {Vector3::Zero(), twist / 2}, {});
  return 4 / h * (after.momentum - momentum);
}

// Whether nothing but locked axes took part in what it gained, and in the momentum by which it was turned.
bool StepRun::IsUntouched(const Mover& mover, Vector3 gained, Vector3 turned) const {
  if (gained.isZero(0) && turned.isZero(0)) return true;
  const SceneEntity& entity = *world_.scene_.entities[Index(mover.row)];
  if (!entity.traits.is_locked || scratch_.jointed[mover.row]) return false;
  DropLocked(entity.desc->rigid_body->locked_axes, gained, turned);
  const auto is_rounding = [](const Vector3& change, const Vector3& whole) {
    return change.squaredNorm() <= kRounding * kRounding * whole.squaredNorm();
  };
  return is_rounding(gained, mover.linear_given) && is_rounding(turned, mover.momentum);
}

// What contacts and joints gave it until the middle of the substep, and what they owe it from there to the boundary.
void StepRun::HoldOver(const Mover& mover, double h, const Vector3& gained, const Vector3& turned) {
  const uint32_t row = Index(mover.row);
  HalfStep& half = world_.layer_.half_steps[row];
  const Vector3& outside = std::as_const(scratch_.accelerations)[mover.row];
  const double interval = mover.past + h / 2;
  const Wrench& uneven = std::as_const(scratch_.uneven)[mover.row];
  const double mass = world_.scene_.entities[row]->mass.mass;
  const Vector3 rate = gained / interval + 2 / (h * mass) * uneven.force;
  const bool is_mean = half.has_past && mover.past > 0 && joints_.GivesMean(mover.row);
  // What was owed is what they gave at the boundary.
  const bool was_mean = half.is_mean && mover.past > 0;
  const Vector3 before = was_mean ? Vector3(half.held_velocity / mover.past) : half.held_rate;
  // What a joint gives when it begins is part of its course, and is known only then.
  const bool begins = !half.has_past && scratch_.jointed[mover.row];
  const Vector3 spun = state_.angular_velocities.col(row);
  const bool is_jolted = (!begins && !is_mean && IsBlow(rate, before, outside, interval)) ||
                         joints_.IsJolted(mover.row, gained, spun - mover.spin_given);
  const bool is_reached = scratch_.reached[mover.row];
  scratch_.jolted.Set(mover.row, is_jolted && !is_reached);
  is_anybody_jolted_ |= is_jolted && !is_reached;
  if (is_reached) {
    // Of what joints gave it, how much they give all the time is not told by a blow, but by what they gave before.
    if (!half.has_past || mover.past == 0) {
      half.held_rate.setZero();
      half.held_torque.setZero();
    }
    half.held_velocity = h / 2 * half.held_rate;
    half.held_momentum = h / 2 * half.held_torque;
  } else if (is_jolted) {
    half.held_velocity = -h / 2 * outside;
    half.held_momentum.setZero();
    half.held_torque.setZero();
  } else {
    const Vector3 torque = turned / interval + 2 / h * uneven.torque;
    if (is_mean) {
      half.held_velocity = h / 2 * (2 * rate - half.held_velocity / mover.past);
      half.held_momentum = h / 2 * (2 * torque - half.held_momentum / mover.past);
    } else {
      const Vector3 twist_before = was_mean ? Vector3(half.held_momentum / mover.past) : half.held_torque;
      const double ahead = half.since_restart >= 2 && joints_.IsFollowed(mover.row) ? h / (2 * mover.past) : 0;
      half.held_velocity = h / 2 * GoneOn(rate, before, ahead);
      half.held_momentum = h / 2 * GoneOn(torque, twist_before, ahead);
    }
    half.held_torque = torque;
  }
  half.is_mean = is_mean && !is_jolted && !is_reached;
  if (!is_reached) half.held_rate = rate;
}

// What the engine made of the velocities that it was given, and the true ones at the boundary, which are shown.
void StepRun::EndMover(Mover& mover, double h) {
  const uint32_t row = Index(mover.row);
  HalfStep& half = world_.layer_.half_steps[row];
  const BodyTraits& traits = world_.scene_.entities[row]->traits;
  const Vector3 gained = state_.linear_velocities.col(row) - mover.linear_given;
  // The engine turned the body by a mean spin; what it changed of that is an impulse, and the rest is the momentum.
  const Vector3 turned = mover.turned.tensor * (state_.angular_velocities.col(row) - mover.spin_given);

  half.velocity = state_.linear_velocities.col(row);
  half.momentum = mover.momentum + turned;
  half.in_flight = IsUntouched(mover, gained, turned);
  const Push steady = scratch_.wrenches.empty() ? mover.steady : SteadyPush(mover.row);
  half.steady_kick = h / 2 * steady.acceleration;
  half.steady_twist = h / 2 * steady.torque;
  const Vector3 outside = steady.acceleration + mover.field.acceleration;
  scratch_.accelerations[mover.row] = outside;
  HoldOver(mover, h, gained, turned);
  half.substep = h;
  half.has_past = true;
  half.restarts = false;
  half.is_struck = false;
  if (std::exchange(half.is_woken, false))
    undo_.KeepTouches(mover.row, std::exchange(world_.layer_.last_touches[row], {}));
  half.is_drawn = false;
  if (half.since_restart < HalfStep::kPause) ++half.since_restart;

  // What is followed turned as its momentum does, which gives no energy.
  if (scratch_.jointed[mover.row] && !joints_.IsFollowed(mover.row)) {
    KeepEarned(mover, h, turned);
  } else {
    TakeTensors(mover);
  }
  // What pushes it out of an overlap is in no velocity.
  if (traits.may_sleep && half.velocity.squaredNorm() <= traits.rest_speed * traits.rest_speed) {
    const Vector3& center = world_.scene_.entities[row]->mass.center_of_mass;
    const Vector3 way = state_.pose(mover.row).Transform(center) - mover.start.Transform(center);
    if ((way - h * half.velocity).norm() > traits.rest_speed * h) scratch_.pushed.Mark(mover.row);
  }
  // By the fields of where it is now.
  const Push pull = FieldPush(mover.row);
  const Vector3 acceleration = mover.field.acceleration + (pull.acceleration - mover.pull.acceleration);
  const Vector3 torque = mover.field.torque + (pull.torque - mover.pull.torque);
  const Motion motion =
      Slowed(ResistanceOf(mover), h / 2, {half.velocity, half.momentum},
             {half.steady_kick + h / 2 * acceleration, mover.yield * (half.steady_twist + h / 2 * torque)},
             {half.held_velocity, half.held_momentum});
  state_.linear_velocities.col(row) = Limited(motion.linear + half.held_velocity, traits.linear_speed_max);
  const Vector3 spin = mover.turned.inverse * (motion.momentum + half.held_momentum);
  state_.angular_velocities.col(row) = Limited(spin, traits.angular_speed_max);
  if (half.in_flight) NoteTurn(mover.row, steady.acceleration + pull.acceleration);
}

// Who flies slowly but is pushed on only turns round, or begins to move.
void StepRun::NoteTurn(EntityRow row, const Vector3& acceleration) {
  const BodyTraits& traits = world_.scene_.entities[Index(row)]->traits;
  if (!traits.may_sleep || state_.linear_velocities.col(Index(row)).norm() > traits.rest_speed) return;
  const double gravity = std::abs(traits.gravity_scale) * world_.scene_.world.gravity.norm();
  if (acceleration.norm() > std::max(kBalanced * gravity, kNoPush)) scratch_.pushed.Mark(row);
}

// Free, a body keeps the energy that it had before it turned. What joints turn otherwise than it would go by itself
// gets some beyond what they did to it while they `turned` it, or loses some: as much to and fro while steps resolve
// the motion, and ever more while they do not. Takes what is too much, and the tensors at the new pose.
void StepRun::KeepEarned(Mover& mover, double h, const Vector3& turned) {
  HalfStep& half = world_.layer_.half_steps[Index(mover.row)];
  const Vector3 spun = state_.angular_velocities.col(Index(mover.row));
  const double before = mover.momentum.dot(mover.turned.inverse * mover.momentum) / 2;
  const double done = turned.dot(mover.spin_given + spun) / 2;
  TakeTensors(mover);
  const double after = half.momentum.dot(mover.turned.inverse * half.momentum) / 2;
  const double gain = after - before - done;
  half.peak = std::max({half.peak * std::max(1 - h / kPeakFades, 0.0), before, after});
  const double most = kUnearnedPart * half.peak;
  // What it got while it had more is not asked back.
  const double excess = std::min(half.unearned + gain - most, gain);
  half.unearned = std::max(half.unearned + gain - std::max(excess, 0.0), -most);
  if (excess > 0) half.momentum *= std::sqrt(std::max(1 - excess / after, 0.0));
  // Steps cannot follow how that goes on.
  if (excess > 0 || spun.norm() * h > kResolvedTurn) {
    half.held_velocity.setZero();
    half.held_momentum.setZero();
    half.held_torque.setZero();
  }
}

}  // namespace genphys

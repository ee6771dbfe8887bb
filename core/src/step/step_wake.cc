// Who is woken by what moves. A sleeper weighs infinitely much until it wakes, so it has to be awake before the engine
// would stop something at it: when it is touched, and before a substep in which it could be.
#include <algorithm>
#include <utility>
#include <vector>

#include "motion/free_rotation.h"
#include "pairs/disjoint_sets.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// What closes at some speed gives nobody more than about so many times that: something long, hit near its middle, goes
// faster at its ends than where it is hit.
constexpr double kGainMost = 2;

}  // namespace

void StepRun::CollideWoken() {
  const std::vector<EntityRow> woken = world_.roused_;
  CollideAndWake(&woken);
}

bool StepRun::WakeTouched() {
  // Copied, since waking changes what is active.
  std::vector<EntityRow> touched;
  const auto& contacts = world_.contacts_;
  for (const ContactPair& pair : contacts.pairs) {
    if (pair.is_sensor) continue;
    const auto first = contacts.points.begin() + pair.first_point;
    for (const EntityRow row : {pair.entity_a, pair.entity_b}) {
      if (!state_.asleep[Index(row)] || world_.layer_.faulted[Index(row)]) continue;
      const bool touches = std::any_of(first, first + pair.point_count,
                                       [](const ContactPoint& point) { return point.depth >= kTouchingDepth; });
      if (touches) touched.push_back(row);
    }
  }
  WakeCarried(touched);
  for (EntityRow row : touched) world_.WakeIslandOf(row);
  world_.WakeStirred();
  return !touched.empty();
}

// Whoever sleeps on a joint to what now moves by itself.
void StepRun::WakeCarried(std::vector<EntityRow>& carried) const {
  if (world_.roused_.empty() && !joints_.HoldSleeper()) return;
  for (const std::span<const EntityRow> rows :
       {std::span<const EntityRow>(rows_), {kinematic_rows_}, {world_.roused_}}) {
    for (const EntityRow row : rows) {
      if (!world_.active_[Index(row)]) continue;
      for (const uint32_t slot : world_.joint_index_.Of(row)) {
        const JointDesc& joint = world_.scene_.joints[slot]->desc;
        const EntityRow other = RowOf(joint.entity_a) == row ? RowOf(joint.entity_b) : RowOf(joint.entity_a);
        if (other == kWorldRow || !state_.asleep[Index(other)] || world_.layer_.faulted[Index(other)]) continue;
        carried.push_back(other);
      }
    }
  }
}

// Wakes whom the coming substep of `h` seconds may bring together with something. Velocities are those at its start,
// and points have the relative ones.
void StepRun::WakeMet(double h) {
  // Who was woken may pass on what comes to it, and meet others that way.
  for (std::vector<EntityRow> met = FindMet(h); !met.empty(); met = FindMet(h)) {
    for (const EntityRow row : met) world_.WakeIslandOf(row);
    world_.WakeStirred();
    CollideWoken();
    world_.near_->PutInOrder(world_.contacts_);
    FillRelativeVelocities(nullptr);
  }
}

// Sleepers across a gap that may be closed by the end of the substep: by how the other one moves, by what pushes it,
// and by what the solve may pass on to it.
std::vector<EntityRow> StepRun::FindMet(double h) {
  const ContactBuffer& contacts = world_.contacts_;
  struct Gap {
    const ContactPair* pair;
    EntityRow sleeper;
    EntityRow other;
  };
  std::vector<Gap> gaps;
  for (const ContactPair& pair : contacts.pairs) {
    if (pair.is_sensor) continue;
    for (const auto& [row, other] :
         {std::pair(pair.entity_a, pair.entity_b), std::pair(pair.entity_b, pair.entity_a)}) {
      const bool sleeps = state_.asleep[Index(row)] && !world_.layer_.faulted[Index(row)];
      if (sleeps && world_.active_[Index(other)]) gaps.push_back({&pair, row, other});
    }
  }
  if (gaps.empty()) return {};
  GatherFields(h);
  FindDrives(h);
  std::vector<EntityRow> met;
  for (const auto& [pair, sleeper, other] : gaps) {
    const double sign = sleeper == pair->entity_b ? 1 : -1;
    const Push push = WholePush(other);
    const double drive = std::as_const(scratch_.drives)[other];
    const auto first = contacts.points.begin() + pair->first_point;
    const bool is_met = std::any_of(first, first + pair->point_count, [&](const ContactPoint& point) {
      const Vector3 gained = sign * GainAt(other, push, point.position, h);
      const double closing = (gained - point.relative_velocity).dot(point.normal) + drive;
      return point.depth >= kTouchingDepth - h * std::max(0.0, closing);
    });
    if (is_met) met.push_back(sleeper);
  }
  return met;
}

// How much faster (m/s) the coming solve may make each mover, of all that hangs together with it: what closes there or
// is torn apart at joints. What holds something as it did in the last substep makes nothing faster.
void StepRun::FindDrives(double h) {
  scratch_.drives.Clear();
  RowValues<int>& numbers = scratch_.struck_index;
  for (size_t i = 0; i < movers_.size(); ++i) numbers[movers_[i].row] = static_cast<int>(i);
  DisjointSets sets(movers_.size());
  std::vector<double> drives(movers_.size());
  const auto drive = [&](EntityRow row_a, EntityRow row_b, double speed) {
    const auto number = [&](EntityRow row) { return row == kWorldRow ? -1 : std::as_const(numbers)[row]; };
    const int a = number(row_a), b = number(row_b);
    if (a >= 0 && b >= 0) sets.Join(static_cast<uint32_t>(a), static_cast<uint32_t>(b));
    if (a < 0 && b < 0) return;
    double& most = drives[static_cast<size_t>(std::max(a, b))];
    most = std::max(most, speed);
  };
  for (const ContactPair& pair : world_.contacts_.pairs) {
    // Of sleepers that somebody comes to it is not known yet whether they take part.
    if (pair.is_sensor || state_.asleep[Index(pair.entity_a)] || state_.asleep[Index(pair.entity_b)]) continue;
    drive(pair.entity_a, pair.entity_b, DriveOf(pair, h));
  }
  for (const Mover& mover : movers_) {
    if (!scratch_.jointed[mover.row]) continue;
    for (const uint32_t slot : world_.joint_index_.Of(mover.row)) {
      const JointDesc& joint = world_.scene_.joints[slot]->desc;
      drive(RowOf(joint.entity_a), RowOf(joint.entity_b), DriveOf(joint, h));
    }
  }
  numbers.Clear();
  for (uint32_t i = 0; i < drives.size(); ++i) {
    double& most = drives[sets.Find(i)];
    most = std::max(most, drives[i]);
  }
  for (uint32_t i = 0; i < drives.size(); ++i) scratch_.drives[movers_[i].row] = kGainMost * drives[sets.Find(i)];
}

// How fast (m/s) the two come together where they meet in the substep.
double StepRun::DriveOf(const ContactPair& pair, double h) const {
  const Push push_a = NewPush(pair.entity_a), push_b = NewPush(pair.entity_b);
  const auto points = std::span(world_.contacts_.points).subspan(pair.first_point, pair.point_count);
  double most = 0;
  for (const ContactPoint& point : points) {
    const Vector3 gained =
        GainAt(pair.entity_b, push_b, point.position, h) - GainAt(pair.entity_a, push_a, point.position, h);
    const double closing = -(point.relative_velocity + gained).dot(point.normal);
    if (point.depth + h * closing >= 0) most = std::max(most, closing);
  }
  return most;
}

// How fast what a joint holds goes apart, at its frames.
double StepRun::DriveOf(const JointDesc& joint, double h) const {
  const auto velocity = [&](const EntityRef& entity, const std::optional<Pose>& frame) -> Vector3 {
    const EntityRow row = RowOf(entity);
    if (row == kWorldRow) return Vector3::Zero();
    const Vector3 point = state_.pose(row).Transform(frame->position);
    return VelocityAt(row, CenterOf(row), point) + GainAt(row, NewPush(row), point, h);
  };
  return (velocity(joint.entity_b, joint.frame_in_b) - velocity(joint.entity_a, joint.frame_in_a)).norm();
}

// Gravity, forces and fields.
Push StepRun::WholePush(EntityRow row) const {
  if (!world_.active_[Index(row)] || !IsDynamic(row)) return {};
  const Push steady = SteadyPush(row), field = FieldPush(row);
  const Wrench& sample = std::as_const(scratch_.samples)[row];
  return {steady.acceleration + field.acceleration + sample.force / world_.scene_.entities[Index(row)]->mass.mass,
          steady.torque + field.torque + sample.torque};
}

// Of these, what did not act in the last substep: what did is held already where something holds it.
Push StepRun::NewPush(EntityRow row) const {
  if (!world_.active_[Index(row)] || !IsDynamic(row)) return {};
  const SceneEntity& entity = *world_.scene_.entities[Index(row)];
  const HalfStep& half = world_.layer_.half_steps[Index(row)];
  Push push = WholePush(row);
  if (half.restarts) {
    push.acceleration -= entity.traits.gravity_scale * world_.scene_.world.gravity;
    return push;
  }
  // Fields that begin or change restart whom they act on.
  const double last = world_.layer_.last_substep;
  const Push field = FieldPush(row);
  const Wrench& sample = std::as_const(scratch_.last_samples)[row];
  push.acceleration -= field.acceleration + 2 / last * half.steady_kick + sample.force / entity.mass.mass;
  push.torque -= field.torque + 2 / last * half.steady_twist + sample.torque;
  return push;
}

// What a push adds in `h` seconds to the velocity of a point of the body, m/s.
Vector3 StepRun::GainAt(EntityRow row, const Push& push, const Vector3& point, double h) const {
  Vector3 gain = h * push.acceleration;
  if (push.torque.isZero(0)) return gain;
  const Matrix3 inverse =
      WorldTensor(state_.pose(row).orientation, world_.scene_.entities[Index(row)]->mass.inverse_tensor);
  return gain + h * (inverse * push.torque).cross(point - CenterOf(row));
}

}  // namespace genphys

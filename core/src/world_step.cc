#include <algorithm>
#include <cmath>
#include <utility>

#include "cat.h"
#include "event_order.h"
#include "free_rotation.h"
#include "genphys/limits.h"
#include "initial_world.h"
#include "sleeping.h"
#include "step_run.h"
#include "validate.h"

namespace genphys {
namespace {

// m/s: points that slide faster have the kinetic coefficient.
constexpr double kSlidingSpeed = 1e-2;
// m/s, on top of what gravity alone brings up in two substeps: a slower approach is rest, not an impact.
constexpr double kBounceSpeedMin = 1e-3;

// Exact turn by a constant angular velocity.
Quaternion Turned(const Quaternion& orientation, const Vector3& spin, double h) {
  const double angle = spin.norm() * h;
  if (angle == 0) return orientation;
  return (Quaternion(Eigen::AngleAxisd(angle, spin.normalized())) * orientation).normalized();
}

Vector3 Limited(const Vector3& velocity, const std::optional<double>& speed_max) {
  if (!speed_max) return velocity;
  const double speed = velocity.norm();
  return speed > *speed_max ? Vector3(velocity * (*speed_max / speed)) : velocity;
}

}  // namespace

Status World::Step(std::optional<double> step_size) {
  if (faulted_) return Refuse(Reason::kWorldFaulted, "", "the world is faulted: it can be read and reset");
  const double size = step_size.value_or(scene_.world.stepper.step_size);
  GENPHYS_RETURN_IF_ERROR(CheckNumber(size, Limits::kStepSizeMin, Limits::kStepSizeMax, "step_size_seconds"));
  if (layer_.step == 0) initial_.reset(new Initial{scene_, state_, layer_});
  return StepRun(*this, size).Run();
}

StepRun::StepRun(World& world, double step_size)
    : world_(world),
      step_size_(step_size),
      state_(world.state_),
      fields_(world.scene_, world.state_),
      touches_(world.rule_, world.state_, world.scene_.world.recorded_events, world.layer_.touching),
      joints_(world.scene_, world.state_, world.active_, world.layer_) {}

Status StepRun::Run() {
  if (world_.record_stats_) {
    world_.stats_ = {};
    mark_ = std::chrono::steady_clock::now();
  }
  if (world_.engine_ != nullptr) {
    CollectRows();
    // Nothing moves, so nothing can come to touch: nothing is called.
    if (!rows_.empty() || !kinematic_rows_.empty()) {
      try {
        Advance();
      } catch (const EngineFault& fault) {
        Restore();
        joints_.Restore();
        return world_.Diverged(fault.what());
      }
    }
  }
  ++world_.layer_.step;
  world_.layer_.simulation_time += step_size_;
  if (world_.engine_ != nullptr) Report();
  return absl::OkStatus();
}

void StepRun::Mark(std::string_view stage) {
  if (!world_.record_stats_) return;
  const auto now = std::chrono::steady_clock::now();
  const auto spent = static_cast<uint64_t>(std::chrono::nanoseconds(now - mark_).count());
  mark_ = now;
  auto& stages = world_.stats_.stages;
  const auto same = std::find_if(stages.begin(), stages.end(), [&](const auto& s) { return s.name == stage; });
  if (same == stages.end()) {
    stages.push_back({stage, spent});
  } else {
    same->nanoseconds += spent;
  }
}

bool StepRun::IsDynamic(EntityRow row) const {
  return world_.scene_.entities[Index(row)]->desc->rigid_body->motion_type == MotionType::kDynamic;
}

void StepRun::CollectRows() {
  for (uint32_t row = 0; row < state_.rows(); ++row) {
    if (world_.active_[row]) (IsDynamic(EntityRow{row}) ? rows_ : kinematic_rows_).push_back(EntityRow{row});
  }
}

void StepRun::Save(EntityRow entity, bool asleep) {
  const uint32_t row = Index(entity);
  saved_.push_back(
      {entity, state_.pose(entity), state_.linear_velocities.col(row), state_.angular_velocities.col(row), asleep});
}

void StepRun::Restore() {
  for (const Saved& saved : saved_) {
    state_.set_pose(saved.row, saved.pose);
    state_.linear_velocities.col(Index(saved.row)) = saved.linear_velocity;
    state_.angular_velocities.col(Index(saved.row)) = saved.angular_velocity;
    state_.asleep[Index(saved.row)] = saved.asleep;
  }
}

void StepRun::AddMover(EntityRow row) {
  Mover& mover = movers_.emplace_back();
  mover.row = row;
  mover.linear_start = state_.linear_velocities.col(Index(row));
  mover.momentum_start = WorldTensor(state_.pose(row).orientation, world_.scene_.entities[Index(row)]->mass.tensor) *
                         state_.angular_velocities.col(Index(row));
}

void StepRun::Advance() {
  tested_.assign(state_.rows(), false);
  for (EntityRow row : rows_) Save(row, false);
  for (EntityRow row : kinematic_rows_) Save(row, false);
  for (EntityRow row : rows_) AddMover(row);
  const uint32_t substeps = world_.backend_->Resolve(world_.scene_.world.stepper).substeps;
  substep_ = step_size_ / substeps;
  if (world_.contacts_stale_) CollideAndWake();
  for (uint32_t i = 0; i < substeps; ++i) Substep(substep_);
  FinishNetForces();
  FinishJoints();
  CountForcesDown();
}

void StepRun::FinishJoints() {
  for (JointId id : joints_.Finish(step_size_)) broken_.push_back(world_.Break(id));
}

void StepRun::CollideAndWake() {
  do {
    for (uint32_t row = 0; row < state_.rows(); ++row) tested_[row] |= world_.active_[row];
    world_.engine_->Collide(world_.rule_, world_.contacts_);
    world_.contacts_stale_ = false;
  } while (WakeTouched());
  FillRelativeVelocities();
  // Whoever was woken moves from here on.
  for (uint32_t index = 0; index < state_.rows(); ++index) {
    const EntityRow row{index};
    if (!world_.active_[index] || !IsDynamic(row)) continue;
    const auto place = std::lower_bound(rows_.begin(), rows_.end(), row);
    if (place != rows_.end() && *place == row) continue;
    rows_.insert(place, row);
    Save(row, true);
    AddMover(row);
  }
  Mark("collide");
}

bool StepRun::WakeTouched() {
  // Copied, since waking changes what is active.
  std::vector<EntityRow> touched;
  const auto& contacts = world_.contacts_;
  for (const ContactPair& pair : contacts.pairs) {
    if (pair.is_sensor) continue;
    for (const EntityRow row : {pair.entity_a, pair.entity_b}) {
      if (!state_.asleep[Index(row)] || world_.layer_.faulted[Index(row)]) continue;
      if (WillTouch(pair)) touched.push_back(row);
    }
  }
  WakeCarried(touched);
  for (EntityRow row : touched) world_.WakeIslandOf(row);
  return !touched.empty();
}

// Whether the two touch, or come so near in the next substep that the engine would stop one at the other: a sleeper
// must be awake by then, for it weighs infinitely much until it is.
bool StepRun::WillTouch(const ContactPair& pair) const {
  const Vector3 center_a = CenterOf(pair.entity_a), center_b = CenterOf(pair.entity_b);
  const auto falls = [&](EntityRow row) -> Vector3 {
    const RigidBody& body = *world_.scene_.entities[Index(row)]->desc->rigid_body;
    const bool moves = world_.active_[Index(row)] && body.motion_type == MotionType::kDynamic;
    return moves ? Vector3(substep_ * body.gravity_scale * world_.scene_.world.gravity) : Vector3(Vector3::Zero());
  };
  const Vector3 gained = falls(pair.entity_b) - falls(pair.entity_a);
  const auto first = world_.contacts_.points.begin() + pair.first_point;
  return std::any_of(first, first + pair.point_count, [&](const ContactPoint& p) {
    const Vector3 velocity =
        VelocityAt(pair.entity_b, center_b, p.position) - VelocityAt(pair.entity_a, center_a, p.position) + gained;
    return p.depth >= kTouchingDepth + substep_ * std::min(0.0, velocity.dot(p.normal));
  });
}

// Whoever sleeps on a joint to what now moves by itself.
void StepRun::WakeCarried(std::vector<EntityRow>& carried) const {
  for (const std::optional<SceneJoint>& joint : world_.scene_.joints) {
    if (!joint) continue;
    const EntityRow a = RowOf(joint->desc.entity_a), b = RowOf(joint->desc.entity_b);
    for (const auto& [row, other] : {std::pair(a, b), std::pair(b, a)}) {
      if (row == kWorldRow || other == kWorldRow || !world_.active_[Index(other)]) continue;
      if (state_.asleep[Index(row)] && !world_.layer_.faulted[Index(row)]) carried.push_back(row);
    }
  }
}

void StepRun::Substep(double h) {
  GatherForces(h);
  for (Mover& mover : movers_) KickRow(mover, h);
  RetireStrays();
  ChooseFriction();
  Mark("kick");
  world_.engine_->Solve(h, rows_, state_, world_.contacts_, joints_.Write(h));
  Mark("solve");
  joints_.Take(h);
  Unkick();
  Bounce(h);
  LimitSpeeds();
  MoveKinematic(h);
  RetireStrays();
  touches_.AddSolved(world_.contacts_);
  std::swap(world_.contacts_, world_.solved_);
  Mark("layer");
  CollideAndWake();
}

void StepRun::GatherForces(double h) {
  wrenches_.clear();
  if (world_.layer_.forces.empty() && fields_.empty()) return;
  wrenches_.resize(state_.rows());
  fields_.Add(rows_, h, wrenches_);
  for (const PendingForce& pending : world_.layer_.forces) {
    const EntityRow row{pending.id.index()};
    const Pose pose = state_.pose(row);
    const bool own = pending.coordinates == Coordinates::kEntity;
    const Vector3 force = own ? Vector3(pose.orientation * pending.force) : pending.force;
    Wrench& sum = wrenches_[Index(row)];
    sum.force += force;
    sum.torque += own ? Vector3(pose.orientation * pending.torque) : pending.torque;
    if (pending.at_center_of_mass) continue;
    const Vector3& center = world_.scene_.entities[Index(row)]->mass.center_of_mass;
    sum.torque += (pose.orientation * (pending.point - center)).cross(force);
  }
}

void StepRun::KickRow(Mover& mover, double h) {
  const uint32_t row = Index(mover.row);
  const SceneEntity& entity = *world_.scene_.entities[row];
  const RigidBody& body = *entity.desc->rigid_body;
  const Wrench applied = wrenches_.empty() ? Wrench{} : wrenches_[row];
  const Vector3 acceleration = body.gravity_scale * world_.scene_.world.gravity + applied.force / entity.mass.mass;
  Vector3 linear = state_.linear_velocities.col(row) + h * acceleration;
  if (body.linear_damping > 0) linear *= std::exp(-body.linear_damping * h);
  const Quaternion orientation = state_.pose(mover.row).orientation;
  mover.tensor = WorldTensor(orientation, entity.mass.tensor);
  mover.momentum = mover.tensor * state_.angular_velocities.col(row) + h * applied.torque;
  if (body.angular_damping > 0) mover.momentum *= std::exp(-body.angular_damping * h);
  const Matrix3 inverse_tensor = WorldTensor(orientation, entity.mass.inverse_tensor);
  if (!fields_.empty()) fields_.Drag(mover.row, h, inverse_tensor, linear, mover.momentum);
  state_.linear_velocities.col(row) = Limited(linear, body.linear_speed_max);

  Vector3 spin = inverse_tensor * mover.momentum;
  if (body.angular_speed_max && spin.norm() > *body.angular_speed_max) {
    spin = Limited(spin, body.angular_speed_max);
    mover.momentum = mover.tensor * spin;
  }
  const bool uniform = entity.mass.spherical || !(spin.norm() <= Limits::kSpinMax);
  mover.spin_given = uniform ? spin : MeanFreeSpin(orientation, mover.momentum, entity.mass.inverse_tensor, h);
  state_.angular_velocities.col(row) = mover.spin_given;
}

MovingBody StepRun::BodyOf(EntityRow entity) const {
  const uint32_t row = Index(entity);
  MovingBody body;
  body.linear_velocity = state_.linear_velocities.col(row);
  body.angular_velocity = state_.angular_velocities.col(row);
  const SceneEntity& scene_entity = *world_.scene_.entities[row];
  const Pose pose = state_.pose(entity);
  body.center = pose.position;
  if (scene_entity.desc->rigid_body->motion_type != MotionType::kDynamic) return body;
  body.center = pose.Transform(scene_entity.mass.center_of_mass);
  if (!world_.active_[row]) return body;
  body.inverse_mass = 1 / scene_entity.mass.mass;
  body.inverse_tensor = WorldTensor(pose.orientation, scene_entity.mass.inverse_tensor);
  return body;
}

void StepRun::FillRelativeVelocities() {
  ContactBuffer& contacts = world_.contacts_;
  for (const ContactPair& pair : contacts.pairs) {
    const Vector3 center_a = CenterOf(pair.entity_a), center_b = CenterOf(pair.entity_b);
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      ContactPoint& point = contacts.points[i];
      point.relative_velocity =
          VelocityAt(pair.entity_b, center_b, point.position) - VelocityAt(pair.entity_a, center_a, point.position);
    }
  }
}

Vector3 StepRun::CenterOf(EntityRow row) const {
  return state_.pose(row).Transform(world_.scene_.entities[Index(row)]->mass.center_of_mass);
}

Vector3 StepRun::VelocityAt(EntityRow row, const Vector3& center, const Vector3& point) const {
  const Vector3 spin = state_.angular_velocities.col(Index(row));
  return state_.linear_velocities.col(Index(row)) + spin.cross(point - center);
}

void StepRun::ChooseFriction() {
  ContactBuffer& contacts = world_.contacts_;
  approach_.resize(contacts.points.size());
  for (const ContactPair& pair : contacts.pairs) {
    const Vector3 center_a = CenterOf(pair.entity_a), center_b = CenterOf(pair.entity_b);
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      ContactPoint& point = contacts.points[i];
      const Vector3 given =
          VelocityAt(pair.entity_b, center_b, point.position) - VelocityAt(pair.entity_a, center_a, point.position);
      approach_[i] = -given.dot(point.normal);
      // Whether it slides is a matter of its true velocity: this substep's push may be one that friction holds.
      const Vector3& slip = point.relative_velocity;
      const bool slides = (slip - slip.dot(point.normal) * point.normal).norm() > kSlidingSpeed;
      point.friction = slides ? pair.material.kinetic_friction : pair.material.friction;
    }
  }
}

void StepRun::Unkick() {
  for (const Mover& mover : movers_) {
    const uint32_t row = Index(mover.row);
    const MassProperties& mass = world_.scene_.entities[row]->mass;
    if (mass.spherical) continue;
    // The engine turned the body by a mean spin; what it changed of that is an impulse, and the rest is the momentum.
    const Vector3 moved = state_.angular_velocities.col(row);
    const Vector3 momentum = mover.momentum + mover.tensor * (moved - mover.spin_given);
    state_.angular_velocities.col(row) =
        WorldTensor(state_.pose(mover.row).orientation, mass.inverse_tensor) * momentum;
  }
}

void StepRun::Bounce(double h) {
  ContactBuffer& contacts = world_.contacts_;
  const double threshold = kBounceSpeedMin + 2 * world_.scene_.world.gravity.norm() * h;
  std::vector<genphys::Bounce> bounces;
  std::vector<MovingBody> bodies;
  std::vector<EntityRow> body_rows;
  const auto body_index = [&](EntityRow row) {
    const auto found = std::find(body_rows.begin(), body_rows.end(), row);
    if (found != body_rows.end()) return static_cast<uint32_t>(found - body_rows.begin());
    body_rows.push_back(row);
    bodies.push_back(BodyOf(row));
    return static_cast<uint32_t>(bodies.size() - 1);
  };
  for (const ContactPair& pair : contacts.pairs) {
    if (pair.is_sensor || !(pair.material.restitution > 0)) continue;
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      ContactPoint& point = contacts.points[i];
      if (!(point.normal_impulse > 0) || approach_[i] < threshold) continue;
      bounces.push_back({body_index(pair.entity_a), body_index(pair.entity_b), point.position, point.normal,
                         pair.material.restitution * approach_[i], &point.normal_impulse});
    }
  }
  if (bounces.empty()) return;
  ApplyBounces(bounces, bodies);
  for (size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].inverse_mass == 0) continue;
    state_.linear_velocities.col(Index(body_rows[i])) = bodies[i].linear_velocity;
    state_.angular_velocities.col(Index(body_rows[i])) = bodies[i].angular_velocity;
  }
}

void StepRun::LimitSpeeds() {
  for (const Mover& mover : movers_) {
    const uint32_t row = Index(mover.row);
    const RigidBody& body = *world_.scene_.entities[row]->desc->rigid_body;
    if (!body.linear_speed_max && !body.angular_speed_max) continue;
    state_.linear_velocities.col(row) = Limited(state_.linear_velocities.col(row), body.linear_speed_max);
    state_.angular_velocities.col(row) = Limited(state_.angular_velocities.col(row), body.angular_speed_max);
  }
}

void StepRun::MoveKinematic(double h) {
  for (EntityRow row : kinematic_rows_) {
    const Pose pose = state_.pose(row);
    state_.set_pose(row, {pose.position + h * state_.linear_velocities.col(Index(row)),
                          Turned(pose.orientation, state_.angular_velocities.col(Index(row)), h)});
  }
  // Bodies of unequal moments and bounced ones have another velocity than the engine knows; it is told at the next
  // solve, so only the poses that the layer moved are written.
  world_.engine_->WriteState(kinematic_rows_, state_);
}

bool StepRun::Fits(EntityRow entity) const {
  const uint32_t row = Index(entity);
  // Comparisons that are false for NaN as well; a unit quaternion has no element beyond one.
  const auto within = [](const auto& column, double bound) { return (column.array().abs() <= bound).all(); };
  return within(state_.positions.col(row), Limits::kPositionMax) && within(state_.orientations.col(row), 1.5) &&
         within(state_.linear_velocities.col(row), Limits::kSpeedMax) &&
         within(state_.angular_velocities.col(row), Limits::kSpinMax);
}

void StepRun::RetireStrays() {
  std::vector<EntityRow> strays;
  for (const std::vector<EntityRow>* rows : {&rows_, &kinematic_rows_}) {
    for (EntityRow entity : *rows) {
      if (Fits(entity)) continue;
      const uint32_t row = Index(entity);
      const bool finite = state_.positions.col(row).allFinite() && state_.orientations.col(row).allFinite() &&
                          state_.linear_velocities.col(row).allFinite() &&
                          state_.angular_velocities.col(row).allFinite();
      if (!finite) throw EngineFault(Cat("entity ", state_.ids[row].packed(), " is no longer finite"));
      strays.push_back(entity);
    }
  }
  for (EntityRow row : strays) Retire(row);
}

void StepRun::Retire(EntityRow entity) {
  const uint32_t row = Index(entity);
  const auto saved = std::find_if(saved_.begin(), saved_.end(), [&](const Saved& s) { return s.row == entity; });
  state_.set_pose(entity, saved->pose);
  state_.linear_velocities.col(row).setZero();
  state_.angular_velocities.col(row).setZero();
  state_.asleep[row] = true;
  world_.layer_.faulted[row] = true;
  world_.engine_->WriteState({&entity, 1}, state_);
  world_.UpdateActive(entity);
  std::erase(rows_, entity);
  std::erase(kinematic_rows_, entity);
  std::erase_if(movers_, [&](const Mover& mover) { return mover.row == entity; });
  const EntityId id = state_.ids[row];
  std::erase_if(world_.layer_.forces, [&](const PendingForce& force) { return force.id == id; });
  faulted_.push_back(id);
}

void StepRun::FinishNetForces() {
  for (const Mover& mover : movers_) {
    const uint32_t row = Index(mover.row);
    const MassProperties& mass = world_.scene_.entities[row]->mass;
    const Vector3 momentum =
        WorldTensor(state_.pose(mover.row).orientation, mass.tensor) * state_.angular_velocities.col(row);
    state_.net_forces.col(row) = mass.mass / step_size_ * (state_.linear_velocities.col(row) - mover.linear_start);
    state_.net_torques.col(row) = (momentum - mover.momentum_start) / step_size_;
  }
}

void StepRun::CountForcesDown() {
  for (PendingForce& force : world_.layer_.forces) --force.steps_left;
  std::erase_if(world_.layer_.forces, [](const PendingForce& force) { return force.steps_left == 0; });
}

void StepRun::Report() {
  LayerState& layer = world_.layer_;
  const bool ran = !tested_.empty();
  std::vector<EventKind> events;
  if (ran) {
    touches_.AddFinal(world_.contacts_);
    touches_.KeepUntested(tested_);
    touches_.Report(events);
    layer.touching = touches_.Pairs();
  }
  const EventKinds& kinds = world_.scene_.world.recorded_events;
  for (EntityId id : world_.woken_) events.push_back(EntityWoke{id});
  world_.woken_.clear();
  const std::vector<EntityRow> sleepers = RowsToSleep(world_.scene_, state_, rows_, world_.active_, step_size_, layer);
  world_.RememberTouches(sleepers);
  for (EntityRow row : sleepers) {
    state_.asleep[Index(row)] = true;
    state_.linear_velocities.col(Index(row)).setZero();
    state_.angular_velocities.col(Index(row)).setZero();
    state_.net_forces.col(Index(row)).setZero();
    state_.net_torques.col(Index(row)).setZero();
    world_.engine_->WriteState({&row, 1}, state_);
    world_.UpdateActive(row);
    if (kinds.sleeping) events.push_back(EntitySlept{state_.ids[Index(row)]});
  }
  if (kinds.moving) ReportMoving(world_.scene_, state_, rows_, layer, events);
  for (EntityId id : faulted_) events.push_back(EntityFaulted{id});
  if (kinds.joints) {
    for (const JointBroke& broken : broken_) events.push_back(broken);
  }
  SortCanonically(events);
  for (EventKind& event : events) world_.Record(std::move(event));
  Mark("report");
  FillStats();
}

void StepRun::FillStats() {
  if (!world_.record_stats_) return;
  world_.stats_.entities_asleep =
      static_cast<uint32_t>(std::count(state_.asleep.begin(), state_.asleep.end(), uint8_t{1}));
  world_.stats_.entities_in_engine = static_cast<uint32_t>(rows_.size());
  world_.stats_.pairs = static_cast<uint32_t>(world_.contacts_.pairs.size());
  world_.stats_.contacts = static_cast<uint32_t>(world_.contacts_.points.size());
}

}  // namespace genphys

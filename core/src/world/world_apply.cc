// How commands change a world. All were validated as one batch before the first is applied, so nothing here can fail.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "commands/command_validator.h"
#include "genphys/work_watch.h"
#include "genphys/world.h"
#include "motion/free_rotation.h"
#include "motion/locked_axes.h"
#include "pairs/near_pairs.h"
#include "step/event_order.h"
#include "world/initial_world.h"

namespace genphys {
namespace {

// Parts of a description that the engine's body is made from.
constexpr uint32_t kShapedBy =
    static_cast<uint32_t>(EntityField::kRigidBody) | static_cast<uint32_t>(EntityField::kMotionType) |
    static_cast<uint32_t>(EntityField::kGeometries) | static_cast<uint32_t>(EntityField::kInertia) |
    static_cast<uint32_t>(EntityField::kErrorCorrection);
// Parts that say where it is or how it moves.
constexpr uint32_t kMovedBy = static_cast<uint32_t>(EntityField::kPose) |
                              static_cast<uint32_t>(EntityField::kLinearVelocity) |
                              static_cast<uint32_t>(EntityField::kAngularVelocity);
// Parts that no physics depends on: they wake nobody.
constexpr uint32_t kLooks =
    static_cast<uint32_t>(EntityField::kDisplayName) | static_cast<uint32_t>(EntityField::kVisual);

Vector3 ToWorld(const Vector3& v, Coordinates coordinates, const Pose& pose) {
  return coordinates == Coordinates::kEntity ? Vector3(pose.orientation * v) : v;
}

bool IsSame(const MassProperties& a, const MassProperties& b) {
  return a.mass == b.mass && a.center_of_mass == b.center_of_mass && a.tensor == b.tensor;
}

// Whether whoever touches the one touches the other, unless that one may no more: surfaces may be of another material.
bool HasSameSurfaces(const EntityDesc& a, const EntityDesc& b) {
  const auto is_same = [](const Geometry& one, const Geometry& other) {
    return one.shape == other.shape && one.pose_in_entity == other.pose_in_entity && one.is_sensor == other.is_sensor;
  };
  return a.rigid_body && b.rigid_body &&
         std::ranges::equal(a.rigid_body->geometries, b.rigid_body->geometries, is_same);
}

// But for what rounding makes of its length.
bool IsSame(const Quaternion& unit, const Quaternion& any) {
  constexpr double kRounding = 4e-16;
  return (any.normalized().coeffs() - unit.coeffs()).cwiseAbs().maxCoeff() <= kRounding;
}

// Who puts somebody elsewhere says how it is turned, and not how often: of all turns that a pose may mean, the joint is
// at the one in the middle of its limits, or next to the only one.
void ForgetTurns(JointKind kind, JointState& state) {
  if (std::holds_alternative<GearJoint>(kind)) return;  // what it slipped, no pose says
  constexpr uint8_t kFirstAngle = 3;
  const auto axes = AxesOf(kind);
  const auto places = PlacesOf(kind);
  std::fill(state.positions.begin() + kFirstAngle, state.positions.end(), 0);
  for (size_t i = 0; i < axes.size(); ++i) {
    if (places[i] < kFirstAngle) continue;
    const double lower = axes[i]->limits.lower.value_or(-HUGE_VAL);
    const double upper = axes[i]->limits.upper.value_or(HUGE_VAL);
    const double middle = (lower + upper) / 2, half = std::numbers::pi;
    state.positions[places[i]] = std::isfinite(middle) ? middle : std::clamp(0.0, lower + half, upper - half);
  }
}

// After velocity and momentum were changed by that much. What joints hold keeps its leapfrog: what they owe is known
// better to it than to the columns, and who is pushed at every step would get energy out of that. What is free or
// touches something starts anew, for how it is held may be another matter from now on.
void GoOnWith(const Vector3& gained, const Vector3& turned, bool is_jointed, HalfStep& half) {
  if (half.restarts || (gained.isZero(0) && turned.isZero(0))) return;
  if (!is_jointed) return half.Restart();
  half.velocity += gained;
  half.momentum += turned;
  half.is_struck = true;
}

}  // namespace

Result<std::vector<CreatedId>> World::Apply(std::span<const Command> commands) {
  if (faulted_) return Refuse(Reason::kWorldFaulted, "", "the world is faulted: it can be read and reset");
  CommandValidator validator(*this);
  try {
    GENPHYS_RETURN_IF_ERROR(validator.Check(commands));
  } catch (const CutShort& cut) {
    return cut.why();
  }
  if (!commands.empty()) ++changes_;
  const size_t first_event = events_.size();
  std::vector<CreatedId> created;
  try {
    created = ApplyAll(commands, validator.prepared());
  } catch (const EngineFault& fault) {
    FinishEvents(first_event);
    return Diverged(fault.what());
  }
  FinishEvents(first_event);
  return created;
}

// What a command does it does to its end: nobody waits long for one.
std::vector<CreatedId> World::ApplyAll(std::span<const Command> commands, std::vector<PreparedEntity>& prepared) {
  std::vector<CreatedId> created;
  created.reserve(commands.size());
  auto next = prepared.begin();
  const auto resolve = [&](EntityRef& entity) {
    if (entity.created_by_command) entity = {created[*entity.created_by_command], {}};
  };
  for (const Command& command : commands) {
    if (!created.empty() && !WorkWatch::Spent(WorkOf(command, entity_count_)).ok()) break;
    const WorkWatch whole({});
    const auto* engine = std::get_if<SetEngine>(&command);
    // Of several engines in a row only the last one is made.
    if (engine == nullptr) MakeDueEngine();
    CreatedId made;
    if (std::holds_alternative<CreateEntity>(command)) {
      made = Create(std::move(next->desc), next->mass);
      ++next;
    } else if (const UpdateEntity* update = std::get_if<UpdateEntity>(&command)) {
      Update(*update, std::move(next->desc), next->mass);
      ++next;
    } else if (const CreateJoint* join = std::get_if<CreateJoint>(&command)) {
      JointDesc joint = join->joint;
      resolve(joint.entity_a);
      resolve(joint.entity_b);
      made = Join(std::move(joint));
    } else if (const CreateForceField* create = std::get_if<CreateForceField>(&command)) {
      made = CreateField(*create, created);
    } else {
      ApplyOne(command);
    }
    created.push_back(made);
  }
  const WorkWatch whole({});
  MakeDueEngine();
  SettleAftermath();
  return created;
}

void World::MakeDueEngine() {
  if (std::exchange(aftermath_.is_engine_due, false)) RebuildEngine();
}

void World::ApplyOne(const Command& command) {
  if (const auto* remove = std::get_if<DeleteEntity>(&command)) {
    Delete(remove->id);
  } else if (const auto* force = std::get_if<ApplyForce>(&command)) {
    Push(*force);
  } else if (const auto* impulse = std::get_if<ApplyImpulse>(&command)) {
    Kick(*impulse);
  } else if (const auto* velocity = std::get_if<SetVelocity>(&command)) {
    Halt(velocity->id);
    ForgetSample(velocity->id);
    SetVelocityNow(*velocity);
  } else if (const auto* pose = std::get_if<SetPose>(&command)) {
    Halt(pose->id);
    ForgetSample(pose->id);
    pose->over_steps > 0 ? SetOut(*pose) : SetPoseNow(*pose);
  } else if (const auto* rejoin = std::get_if<UpdateJoint>(&command)) {
    Rejoin(*rejoin);
  } else if (const auto* unjoin = std::get_if<DeleteJoint>(&command)) {
    UnjoinAndTell(unjoin->id);
  } else if (const auto* motors = std::get_if<SetMotorColumns>(&command)) {
    Drive(*motors);
  } else if (const auto* gravity = std::get_if<SetGravity>(&command)) {
    // Some tell it before every step, whether it changed or not.
    if (gravity->gravity != scene_.world.gravity) WakeAll();
    scene_.world.gravity = gravity->gravity;
  } else if (const auto* stepper = std::get_if<SetStepper>(&command)) {
    scene_.world.stepper = stepper->stepper;
    if (engine_ != nullptr) engine_->SetStepper(backend_->Resolve(stepper->stepper));
  } else if (const auto* engine = std::get_if<SetEngine>(&command)) {
    if (engine->engine != scene_.world.engine) {
      scene_.world.engine = engine->engine;
      aftermath_.is_engine_due = true;
    }
  } else if (const auto* columns = std::get_if<ApplyForceColumns>(&command)) {
    for (size_t i = 0; i < columns->ids.size(); ++i) {
      Push(ApplyForce{.id = columns->ids[i],
                      .force = columns->forces[i],
                      .torque = columns->torques.empty() ? Vector3(Vector3::Zero()) : columns->torques[i],
                      .sampled = columns->sampled});
    }
  } else if (const auto* update = std::get_if<UpdateForceField>(&command)) {
    UpdateField(*update);
  } else if (const auto* end = std::get_if<DeleteForceField>(&command)) {
    DeleteField(end->id);
  }
}

EntityId World::Create(std::shared_ptr<const EntityDesc> desc, const MassProperties& mass) {
  const EntityId id = layer_.ids.Allocate<EntityTag>();
  const uint32_t slot = id.index();
  if (slot >= scene_.entities.size()) Grow();
  const EntityRow row{slot};
  ++entity_count_;
  scene_.entities[slot].emplace(id, std::move(desc), mass);
  state_.ids[slot] = id;
  state_.set_pose(row, scene_.entities[slot]->desc->pose);
  AttachBody(row);
  if (scene_.world.recorded_events.changes) Record(EntityCreated{id, scene_.entities[slot]->desc});
  return id;
}

void World::Grow() {
  // Columns copy when they grow, so room is made for half as many again; rows without a tenant are holes.
  const size_t rows = scene_.entities.size() * 3 / 2 + 1;
  scene_.entities.resize(rows);
  geometry_rows_.resize(rows);
  layer_.rest_times.resize(rows);
  layer_.rest_watches.resize(rows);
  layer_.moving.resize(rows);
  layer_.last_touches.resize(rows);
  layer_.half_steps.resize(rows);
  layer_.faulted.resize(rows);
  reaches_.resize(rows);
  flown_.resize(rows);
  unsettled_.Resize(static_cast<uint32_t>(rows));
  let_go_.Resize(static_cast<uint32_t>(rows));
  state_.Resize(static_cast<uint32_t>(rows));
}

void World::AttachBody(EntityRow entity) {
  const uint32_t row = Index(entity);
  const SceneEntity& scene_entity = *scene_.entities[row];
  const auto& body = scene_entity.desc->rigid_body;
  state_.linear_velocities.col(row) = body ? body->linear_velocity : Vector3(Vector3::Zero());
  state_.angular_velocities.col(row) = body ? body->angular_velocity : Vector3(Vector3::Zero());
  DropLockedOf(entity);
  state_.net_forces.col(row).setZero();
  state_.net_torques.col(row).setZero();
  state_.asleep[row] = false;
  layer_.faulted[row] = false;
  layer_.rest_times[row] = 0;
  layer_.rest_watches[row] = {};
  layer_.moving[row] = 0;
  layer_.last_touches[row].clear();
  layer_.half_steps[row].Forget();
  SetActive(entity, false);
  if (!body) return;
  Unsettle(entity);
  geometry_rows_[row] = rule_.Add(entity, scene_entity.id, *body);
  IgnoreOthers(scene_entity, true);
  contacts_stale_ = true;
  if (engine_ != nullptr) {
    AddToEngine(entity);
  } else {
    SetActive(entity, ShouldBeActive(entity));
  }
  // What does not move by itself is tested against nothing that sleeps, so whatever it was put into must be awake.
  if (body->motion_type != MotionType::kDynamic) WakeWhereItIs(entity);
}

void World::DetachBody(EntityRow entity) {
  const uint32_t row = Index(entity);
  // Joints and springs hold what has no body, too.
  WakeNeighboursOf(entity);
  if (!scene_.entities[row]->desc->rigid_body) return;
  aftermath_.detached.push_back(state_.ids[row]);
  if (engine_ != nullptr) {
    engine_->RemoveBody(entity);
    near_->Remove(geometry_rows_[row]);
  }
  rule_.Remove(geometry_rows_[row]);
  IgnoreOthers(*scene_.entities[row], false);
  geometry_rows_[row].clear();
  SetActive(entity, false);
  // Contact points name rows that are gone now; see DropSolved().
  contacts_.Clear();
  contacts_stale_ = true;
}

// Whether it ignores those whom its description names.
void World::IgnoreOthers(const SceneEntity& entity, bool ignores) {
  for (const EntityId other : entity.desc->rigid_body->ignored_entities) {
    ignores ? rule_.Disregard(entity.id, other) : rule_.Regard(entity.id, other);
  }
}

void World::Update(const UpdateEntity& command, std::shared_ptr<const EntityDesc> desc, const MassProperties& mass) {
  const uint32_t slot = command.id.index();
  const EntityRow row{slot};
  SceneEntity& entity = *scene_.entities[slot];
  const EntityFields& fields = command.fields;
  const bool is_locked_otherwise = entity.desc->rigid_body && desc->rigid_body &&
                                   entity.desc->rigid_body->locked_axes != desc->rigid_body->locked_axes;
  if ((fields.bits & kShapedBy) != 0) {
    const bool had_body = entity.desc->rigid_body.has_value();
    const Vector3 linear = state_.linear_velocities.col(slot), angular = state_.angular_velocities.col(slot);
    // Forces act on, on a body of another shape, unless it is a new one or is moved by none.
    if (fields.Has(EntityField::kRigidBody) || !IsDynamic(*desc)) Unforce(command.id);
    const bool is_as_heavy = had_body && IsSame(entity.mass, mass);
    const uint8_t moving = layer_.moving[slot];
    Wake(row);
    const HalfStep half = layer_.half_steps[slot];
    const bool is_other =
        !had_body || !desc->rigid_body || entity.desc->rigid_body->geometries != desc->rigid_body->geometries;
    if (!HasSameSurfaces(*entity.desc, *desc)) aftermath_.reshaped.push_back(command.id);
    DetachBody(row);
    entity.Become(std::move(desc), mass);
    AttachBody(row);
    // A new body starts as described; a changed one goes on as it moved, if it still can.
    const bool goes_on = had_body && !fields.Has(EntityField::kRigidBody) && entity.desc->rigid_body &&
                         entity.desc->rigid_body->motion_type != MotionType::kStatic;
    if (goes_on) SetVelocityNow({command.id, linear, angular});
    HalfStep& now = layer_.half_steps[slot];
    if (goes_on && is_as_heavy) now = half;
    // With another surface it is held otherwise, and holds otherwise: see EndTouches().
    if (!IsDynamic(*entity.desc)) {
      now.restarts = is_other;
    } else if (is_other) {
      now.RestartNowAndThen();
    }
    if (!goes_on || entity.desc->rigid_body->motion_type != MotionType::kKinematic) EndPassage(command.id);
    if (goes_on && IsDynamic(*entity.desc)) {
      layer_.moving[slot] = moving;
    } else if (scene_.world.recorded_events.moving) {
      // Of what is no dynamic body no step tells it.
      if ((moving & 1) != 0) Record(EntityStoppedMoving{command.id, false});
      if ((moving & 2) != 0) Record(EntityStoppedMoving{command.id, true});
    }
  } else {
    const bool has_body = entity.desc->rigid_body.has_value();
    if (has_body) IgnoreOthers(entity, false);
    entity.Become(std::move(desc), mass);
    if (has_body) IgnoreOthers(entity, true);
  }
  if (fields.Has(EntityField::kIgnoredEntities)) {
    if (near_ != nullptr) near_->Renew(geometry_rows_[slot]);
    contacts_stale_ = true;
    WakeNeighboursOf(row);
    // Whom it is inside may have been ignored until now.
    if (!IsDynamic(*entity.desc)) WakeWhereItIs(row);
  }
  const EntityDesc& now = *entity.desc;
  if ((fields.bits & kMovedBy) != 0) Halt(command.id);
  if (fields.Has(EntityField::kLockedAxes)) DropLockedOf(row);
  // What locks held back is not owed to it.
  if (is_locked_otherwise) layer_.half_steps[slot].Restart();
  if (fields.Has(EntityField::kPose) || fields.Has(EntityField::kLinearVelocity) ||
      fields.Has(EntityField::kAngularVelocity)) {
    ForgetSample(command.id);
  }
  if (fields.Has(EntityField::kPose)) SetPoseNow({command.id, now.pose.position, now.pose.orientation});
  if (fields.Has(EntityField::kLinearVelocity)) SetVelocityNow({command.id, now.rigid_body->linear_velocity, {}});
  if (fields.Has(EntityField::kAngularVelocity)) SetVelocityNow({command.id, {}, now.rigid_body->angular_velocity});
  if (now.rigid_body && (fields.bits & ~kLooks) != 0) UnsettleAndWake(row);
  if (scene_.world.recorded_events.changes) Record(EntityUpdated{command.id, entity.desc, fields});
}

void World::Delete(EntityId id) {
  const EntityRow row{id.index()};
  UnjoinAllOf(id);
  aftermath_.deleted.push_back(id);
  Unforce(id);
  EndPassage(id);
  DetachBody(row);
  scene_.entities[id.index()].reset();
  state_.ids[id.index()] = EntityId();
  state_.set_pose(row, Pose());
  state_.linear_velocities.col(id.index()).setZero();
  state_.angular_velocities.col(id.index()).setZero();
  state_.net_forces.col(id.index()).setZero();
  state_.net_torques.col(id.index()).setZero();
  state_.asleep[id.index()] = false;
  layer_.faulted[id.index()] = false;
  layer_.rest_times[id.index()] = 0;
  layer_.rest_watches[id.index()] = {};
  layer_.last_touches[id.index()].clear();
  layer_.half_steps[id.index()].Forget();
  layer_.ids.Free(id);
  --entity_count_;
  if (scene_.world.recorded_events.changes) Record(EntityDeleted{id});
}

void World::Push(const ApplyForce& command) {
  const EntityRow row{command.id.index()};
  // Nothing moves it until it is put back or told how to go: forces would wait until then, and act all at once.
  if (layer_.faulted[Index(row)]) return;
  if (command.replace) Unforce(command.id);
  WakeIslandOf(row);
  PendingForce force{command.id,          command.force, command.torque, Vector3::Zero(), !command.point.has_value(),
                     command.coordinates, command.steps, command.sampled};
  if (command.point) {
    const Pose pose = state_.pose(row);
    force.point = command.coordinates == Coordinates::kEntity
                      ? *command.point
                      : Vector3(pose.orientation.conjugate() * (*command.point - pose.position));
  }
  layer_.forces.push_back(force);
}

// What it is put to says all: nothing of the last step is to be added.
void World::ForgetSample(EntityId id) {
  if (!layer_.samples.empty()) aftermath_.unsampled.push_back(id);
}

void World::Kick(const ApplyImpulse& command) {
  const uint32_t slot = command.id.index();
  const Pose pose = state_.pose(EntityRow{slot});
  const MassProperties& mass = scene_.entities[slot]->mass;
  const Vector3 linear = ToWorld(command.linear, command.coordinates, pose);
  Vector3 angular = ToWorld(command.angular, command.coordinates, pose);
  if (command.point) {
    const Vector3 point = command.coordinates == Coordinates::kEntity ? pose.Transform(*command.point) : *command.point;
    angular += (point - pose.Transform(mass.center_of_mass)).cross(linear);
  }
  const LockedAxes& locks = scene_.entities[slot]->desc->rigid_body->locked_axes;
  const Vector3 turn = WorldTensor(pose.orientation, mass.inverse_tensor) * angular;
  SetVelocityNow(
      {command.id, state_.linear_velocities.col(slot) + linear / mass.mass,
       state_.angular_velocities.col(slot) + LockedSpin(locks, WorldTensor(pose.orientation, mass.tensor), turn)});
}

void World::SetVelocityNow(const SetVelocity& command) {
  const uint32_t slot = command.id.index();
  const EntityRow row{slot};
  Revive(row);
  const Vector3 linear = state_.linear_velocities.col(slot), angular = state_.angular_velocities.col(slot);
  if (command.linear) state_.linear_velocities.col(slot) = *command.linear;
  if (command.angular) state_.angular_velocities.col(slot) = *command.angular;
  DropLockedOf(row);
  const Matrix3& tensor = scene_.entities[slot]->mass.tensor;
  GoOnWith(state_.linear_velocities.col(slot) - linear,
           WorldTensor(state_.pose(row).orientation, tensor) * (state_.angular_velocities.col(slot) - angular),
           !joint_index_.Of(row).empty(), layer_.half_steps[slot]);
  TellPose(row);
  UnsettleAndWake(row);
  if (!scene_.force_fields.empty()) aftermath_.pushed.push_back(command.id);
  UpdateActive(row);
}

void World::DropLockedOf(EntityRow row) {
  const auto& body = scene_.entities[Index(row)]->desc->rigid_body;
  if (!body || body->motion_type != MotionType::kDynamic || !body->locked_axes.any()) return;
  Vector3 linear = state_.linear_velocities.col(Index(row)), angular = state_.angular_velocities.col(Index(row));
  DropLocked(body->locked_axes, linear, angular);
  state_.linear_velocities.col(Index(row)) = linear;
  state_.angular_velocities.col(Index(row)) = angular;
}

void World::SetPoseNow(const SetPose& command) {
  const uint32_t slot = command.id.index();
  const EntityRow row{slot};
  const Pose before = state_.pose(row);
  if (command.position) state_.positions.col(slot) = *command.position;
  if (command.orientation && !IsSame(before.orientation, *command.orientation)) {
    state_.orientations.col(slot) = ToColumn(command.orientation->normalized());
    for (const uint32_t i : joint_index_.Of(row)) ForgetTurns(scene_.joints[i]->desc.kind, layer_.joints[i]);
  }
  WakeNeighboursOf(row);
  const EntityDesc& desc = *scene_.entities[slot]->desc;
  if (!desc.rigid_body) return;
  if (state_.pose(row) != before) layer_.half_steps[slot].Restart();
  Revive(row);
  TellPose(row);
  contacts_stale_ = true;
  UnsettleAndWake(row);
  if (!IsDynamic(desc)) WakeWhereItIs(row);
}

// Where a kinematic entity goes in the steps to come. It stands until the first of them, but is on its way.
void World::SetOut(const SetPose& command) {
  const EntityRow row{command.id.index()};
  const Pose here = state_.pose(row);
  const Quaternion turned = command.orientation ? command.orientation->normalized() : here.orientation;
  layer_.passages[command.id] = {{command.position.value_or(here.position), turned}, command.over_steps};
  SetVelocityNow({command.id, Vector3(Vector3::Zero()), Vector3(Vector3::Zero())});
}

bool World::IsOnItsWay(EntityId id) const { return layer_.passages.contains(id); }

// It keeps the velocity of its way, if it was on one.
bool World::EndPassage(EntityId id) { return layer_.passages.erase(id) > 0; }

// What moved only to get somewhere stands when it is told something else.
void World::Halt(EntityId id) {
  if (EndPassage(id)) SetVelocityNow({id, Vector3(Vector3::Zero()), Vector3(Vector3::Zero())});
}

void World::Revive(EntityRow row) {
  if (!layer_.faulted[Index(row)]) return;
  layer_.faulted[Index(row)] = false;
  state_.asleep[Index(row)] = false;
  layer_.rest_times[Index(row)] = 0;
  UpdateActive(row);
}

// What a batch has to tell, of which the first is event `first`.
void World::FinishEvents(size_t first) {
  for (EntityId id : std::exchange(woken_, {})) Record(EntityWoke{id});
  SortCanonically(std::span(events_).subspan(first));
}

}  // namespace genphys

#include "commands/command_validator.h"

#include <array>
#include <cmath>
#include <utility>

#include "commands/missing_features.h"
#include "genphys/held_shapes.h"
#include "genphys/limits.h"
#include "genphys/surface.h"
#include "genphys/work_watch.h"
#include "genphys/world.h"
#include "model/cat.h"
#include "model/validate.h"

namespace genphys {
namespace {

// By index of the Command alternative, as the wire spells them.
constexpr std::array<std::string_view, std::variant_size_v<Command>> kCommandNames{
    "create_entity",      "update_entity",      "delete_entity",     "apply_force",  "apply_impulse",
    "set_velocity",       "set_pose",           "set_gravity",       "set_stepper",  "set_engine",
    "apply_forces",       "create_joint",       "update_joint",      "delete_joint", "set_motors",
    "create_force_field", "update_force_field", "delete_force_field"};

constexpr uint32_t kBodyParts =
    static_cast<uint32_t>(EntityField::kMotionType) | static_cast<uint32_t>(EntityField::kGeometries) |
    static_cast<uint32_t>(EntityField::kInertia) | static_cast<uint32_t>(EntityField::kAutoDisable) |
    static_cast<uint32_t>(EntityField::kLinearVelocity) | static_cast<uint32_t>(EntityField::kAngularVelocity) |
    static_cast<uint32_t>(EntityField::kLinearDamping) | static_cast<uint32_t>(EntityField::kAngularDamping) |
    static_cast<uint32_t>(EntityField::kGravityScale) | static_cast<uint32_t>(EntityField::kLinearSpeedMax) |
    static_cast<uint32_t>(EntityField::kAngularSpeedMax) | static_cast<uint32_t>(EntityField::kLockedAxes) |
    static_cast<uint32_t>(EntityField::kErrorCorrection) | static_cast<uint32_t>(EntityField::kIgnoredEntities);

Status CheckWrench(const Vector3& force, const Vector3& torque, const std::optional<Vector3>& point,
                   std::string_view force_name, std::string_view torque_name) {
  GENPHYS_RETURN_IF_ERROR(CheckVector(force, Limits::kForceMax, force_name));
  GENPHYS_RETURN_IF_ERROR(CheckVector(torque, Limits::kForceMax, torque_name));
  return point ? CheckVector(*point, Limits::kPositionMax, "point") : absl::OkStatus();
}

Status CheckColumn(const std::vector<Vector3>& column, std::string_view name) {
  for (size_t i = 0; i < column.size(); ++i) {
    // One comparison per scalar that is false for NaN as well; what a row is called is only worth its time if it is
    // bad.
    const Vector3& row = column[i];
    const bool good = std::abs(row.x()) <= Limits::kForceMax && std::abs(row.y()) <= Limits::kForceMax &&
                      std::abs(row.z()) <= Limits::kForceMax;
    if (!good) return CheckVector(row, Limits::kForceMax, Cat(name, "[", i, "]"));
  }
  return absl::OkStatus();
}

int64_t CountGeometries(const EntityDesc& desc) {
  return desc.rigid_body ? static_cast<int64_t>(desc.rigid_body->geometries.size()) : 0;
}

}  // namespace

int64_t WorkOf(const Command& command, size_t entities) {
  constexpr int64_t kUsual = 512, kEntityOfEngine = 256, kRowOfColumn = 16;
  if (std::holds_alternative<SetEngine>(command)) return kUsual + kEntityOfEngine * static_cast<int64_t>(entities);
  if (const auto* forces = std::get_if<ApplyForceColumns>(&command)) {
    return kUsual + kRowOfColumn * static_cast<int64_t>(forces->ids.size());
  }
  if (const auto* motors = std::get_if<SetMotorColumns>(&command)) {
    return kUsual + kRowOfColumn * static_cast<int64_t>(motors->ids.size());
  }
  return kUsual;
}

WorldDesc CommandValidator::WorldSettings(const World& world) { return world.scene().world; }

Status CommandValidator::Check(std::span<const Command> commands) {
  for (size_t i = 0; i < commands.size(); ++i) {
    WorkWatch::Spend(WorkOf(commands[i], world_.entity_count() + prepared_.size()));
    made_.emplace_back();
    const Status status = std::visit([this](const auto& command) { return (*this)(command); }, commands[i]);
    if (!status.ok()) {
      return WithFieldPrefix(status, Cat("commands[", i, "].", kCommandNames[commands[i].index()]));
    }
  }
  return absl::OkStatus();
}

Result<const EntityDesc*> CommandValidator::Find(EntityId id, std::string_view field) const {
  if (const auto changed = changed_.find(id); changed != changed_.end()) {
    if (changed->second) return changed->second.get();
    return Refuse(Reason::kStaleId, field, Cat("entity ", id.packed(), " is deleted earlier in this batch"));
  }
  GENPHYS_RETURN_IF_ERROR(world_.CheckId(id, field));
  return world_.scene().entities[id.index()]->desc.get();
}

Status CommandValidator::CheckDynamic(EntityId id, std::string_view field) const {
  const Result<const EntityDesc*> desc = Find(id, field);
  if (!desc.ok()) return desc.status();
  const std::optional<RigidBody>& body = (*desc)->rigid_body;
  if (body && body->motion_type == MotionType::kDynamic) return absl::OkStatus();
  return Refuse(Reason::kInvalidValue, field, Cat("entity ", id.packed(), " is not dynamic: no force moves it"));
}

// What the batch deletes is counted all the same.
Status CommandValidator::CheckPending(size_t count, std::string_view field) {
  new_forces_ += count;
  if (world_.layer_state().forces.size() + new_forces_ <= Limits::kPendingForcesMax) return absl::OkStatus();
  return Refuse(Reason::kLimitExceeded, field,
                Cat("at most ", Limits::kPendingForcesMax, " forces of a world wait for a step"));
}

// Shapes that the batch lets go of are counted all the same.
Status CommandValidator::CheckRoom(const EntityDesc& after, const EntityDesc* before) {
  const int64_t gained = CountGeometries(after) - (before == nullptr ? 0 : CountGeometries(*before));
  new_geometries_ += gained;
  const int64_t count = static_cast<int64_t>(world_.rule_.geometry_count()) + new_geometries_;
  if (gained > 0 && count > Limits::kWorldGeometriesMax) {
    return Refuse(Reason::kLimitExceeded, "entity.rigid_body.geometries",
                  Cat("a world holds ", Limits::kWorldGeometriesMax, " geometries"));
  }
  if (!after.rigid_body) return absl::OkStatus();
  const HeldShapes& held = world_.rule_.shapes();
  const std::vector<Geometry>& geometries = after.rigid_body->geometries;
  for (size_t i = 0; i < geometries.size(); ++i) {
    const void* const data = HeldShapes::DataOf(geometries[i].shape);
    if (data == nullptr || held.Has(data) || !new_shapes_.insert(data).second) continue;
    new_shape_bytes_ += DataBytesOf(geometries[i].shape);
    if (held.bytes() + new_shape_bytes_ <= size_t{Limits::kShapeMebibytesMax} << 20) continue;
    return Refuse(
        Reason::kLimitExceeded, Cat("entity.rigid_body.geometries[", i, "].shape"),
        Cat("the hulls, meshes and heightfields of a world take at most ", Limits::kShapeMebibytesMax, " MiB"));
  }
  return absl::OkStatus();
}

Status CommandValidator::Prepare(const EntityDesc& desc, std::string_view path, PreparedEntity& out) const {
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckEntity(desc), path));
  if (const Backend* backend = world_.registry_.Find(settings_.engine)) {
    GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckFeatures(desc, backend->capabilities()), path));
  }
  EntityDesc filled = Filled(desc, settings_);
  if (filled.rigid_body && filled.rigid_body->motion_type == MotionType::kDynamic) {
    Result<MassProperties> mass = ComputeMassProperties(*filled.rigid_body);
    if (!mass.ok()) return WithFieldPrefix(mass.status(), Cat(path, ".rigid_body"));
    out.mass = *mass;
  }
  out.desc = std::make_shared<const EntityDesc>(std::move(filled));
  return absl::OkStatus();
}

// Whom it was once told to ignore may be gone; whom it is told of now must be there.
Status CommandValidator::CheckIgnored(const EntityDesc& desc) const {
  if (!desc.rigid_body) return absl::OkStatus();
  const std::vector<EntityId>& ignored = desc.rigid_body->ignored_entities;
  constexpr std::string_view kField = "entity.rigid_body.ignored_entity_ids";
  if (ignored.size() > Limits::kIgnoredEntitiesMax) {
    return Refuse(
        Reason::kOutOfRange, kField,
        Cat("an entity names at most ", Limits::kIgnoredEntitiesMax, "; for more there are collision spaces"));
  }
  for (size_t i = 0; i < ignored.size(); ++i) {
    GENPHYS_RETURN_IF_ERROR(Find(ignored[i], Cat(kField, "[", i, "]")).status());
  }
  return absl::OkStatus();
}

Status CommandValidator::operator()(const CreateEntity& command) {
  if (world_.entity_count() + ++created_ > Limits::kEntitiesMax) {
    return Refuse(Reason::kLimitExceeded, "entity", Cat("a world holds ", Limits::kEntitiesMax, " entities"));
  }
  GENPHYS_RETURN_IF_ERROR(CheckIgnored(command.entity));
  GENPHYS_RETURN_IF_ERROR(CheckRoom(command.entity, nullptr));
  GENPHYS_RETURN_IF_ERROR(Prepare(command.entity, "entity", prepared_.emplace_back()));
  made_.back() = prepared_.back().desc;
  return absl::OkStatus();
}

Status CommandValidator::operator()(const UpdateEntity& command) {
  const Result<const EntityDesc*> current = Find(command.id, "entity.id");
  if (!current.ok()) return current.status();
  if (!(*current)->rigid_body && !command.fields.Has(EntityField::kRigidBody) &&
      (command.fields.bits & kBodyParts) != 0) {
    return Refuse(Reason::kInvalidValue, "update_mask", "the entity has no rigid_body of which a part could change");
  }
  if (command.fields.Has(EntityField::kIgnoredEntities) || command.fields.Has(EntityField::kRigidBody)) {
    GENPHYS_RETURN_IF_ERROR(CheckIgnored(command.entity));
  }
  PreparedEntity& prepared = prepared_.emplace_back();
  const EntityDesc merged = Merged(**current, command);
  GENPHYS_RETURN_IF_ERROR(CheckRoom(merged, *current));
  GENPHYS_RETURN_IF_ERROR(Prepare(merged, "entity", prepared));
  changed_[command.id] = prepared.desc;
  return absl::OkStatus();
}

Status CommandValidator::operator()(const DeleteEntity& command) {
  const Result<const EntityDesc*> current = Find(command.id, "entity_id");
  if (!current.ok()) return current.status();
  new_geometries_ -= CountGeometries(**current);
  changed_[command.id] = nullptr;
  return absl::OkStatus();
}

Status CommandValidator::operator()(const ApplyForce& command) {
  GENPHYS_RETURN_IF_ERROR(CheckDynamic(command.id, "entity_id"));
  GENPHYS_RETURN_IF_ERROR(CheckNumber(command.steps, 1, Limits::kForceStepsMax, "steps"));
  if (command.sampled && command.steps != 1) {
    return Refuse(Reason::kInvalidValue, "steps",
                  "steps must be 1 or unset: a sampled force is told anew for each step");
  }
  // One that replaces leaves one of its entity, so that there are never more of these than entities.
  if (!command.replace) GENPHYS_RETURN_IF_ERROR(CheckPending(1, "entity_id"));
  return CheckWrench(command.force, command.torque, command.point, "force", "torque");
}

Status CommandValidator::operator()(const ApplyImpulse& command) {
  GENPHYS_RETURN_IF_ERROR(CheckDynamic(command.id, "entity_id"));
  return CheckWrench(command.linear, command.angular, command.point, "linear", "angular");
}

Status CommandValidator::operator()(const SetVelocity& command) {
  const Result<const EntityDesc*> current = Find(command.id, "entity_id");
  if (!current.ok()) return current.status();
  const std::optional<RigidBody>& body = (*current)->rigid_body;
  if (!body || body->motion_type == MotionType::kStatic) {
    return Refuse(Reason::kInvalidValue, "entity_id", Cat("entity ", command.id.packed(), " does not move"));
  }
  if (command.linear) GENPHYS_RETURN_IF_ERROR(CheckVector(*command.linear, Limits::kSpeedMax, "linear"));
  return command.angular ? CheckVector(*command.angular, Limits::kSpinMax, "angular") : absl::OkStatus();
}

Status CommandValidator::operator()(const SetPose& command) {
  const Result<const EntityDesc*> current = Find(command.id, "entity_id");
  if (!current.ok()) return current.status();
  GENPHYS_RETURN_IF_ERROR(CheckNumber(command.over_steps, 0, Limits::kForceStepsMax, "over_steps"));
  const std::optional<RigidBody>& body = (*current)->rigid_body;
  if (command.over_steps > 0 && !(body && body->motion_type == MotionType::kKinematic)) {
    return Refuse(Reason::kInvalidValue, "over_steps",
                  Cat("entity ", command.id.packed(), " is not kinematic: it can only be put somewhere at once"));
  }
  if (command.position) GENPHYS_RETURN_IF_ERROR(CheckVector(*command.position, Limits::kPositionMax, "pose.position"));
  return command.orientation ? CheckOrientation(*command.orientation, "pose.orientation") : absl::OkStatus();
}

Status CommandValidator::operator()(const SetGravity& command) {
  return CheckVector(command.gravity, Limits::kGravityMax, "gravity");
}

Status CommandValidator::operator()(const SetStepper& command) {
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckStepper(command.stepper), "stepper"));
  settings_.stepper = command.stepper;
  const Backend* backend = world_.registry_.Find(settings_.engine);
  if (backend == nullptr) return absl::OkStatus();
  MissingFeatures missing(backend->capabilities());
  missing.Need(command.stepper);
  return missing.Check();
}

Status CommandValidator::operator()(const SetEngine& command) {
  GENPHYS_RETURN_IF_ERROR(CheckEngine(command.engine));
  settings_.engine = command.engine;
  return absl::OkStatus();
}

Status CommandValidator::CheckEngine(const std::string& name) const {
  if (name == "none") return absl::OkStatus();
  const Backend* backend = world_.registry_.Find(name);
  if (backend == nullptr) {
    std::string names;
    for (const auto& each : world_.registry_.backends()) {
      names += (names.empty() ? "" : ", ") + each->capabilities().engine();
    }
    return Refuse(Reason::kInvalidValue, "engine",
                  Cat("there is no engine \"", name, "\"; there are: ", names, ", or none"));
  }
  MissingFeatures missing(backend->capabilities());
  for (const Feature feature : settings_.required_features) missing.Need(feature);
  missing.Need(settings_.stepper);
  if (settings_.default_error_correction.any()) missing.Need(Feature::kErrorCorrection);
  for (const PreparedEntity& prepared : prepared_) missing.Need(*prepared.desc);
  for (const std::optional<SceneEntity>& entity : world_.scene().entities) {
    if (entity && !changed_.contains(entity->id)) missing.Need(*entity->desc);
  }
  for (const JointKind& kind : kinds_) missing.Need(FeatureOf(kind));
  for (const std::optional<SceneJoint>& joint : world_.scene().joints) {
    if (joint && Find(joint->id, "").ok()) missing.Need(FeatureOf(joint->desc.kind));
  }
  return missing.Check();
}

Status CommandValidator::operator()(const ApplyForceColumns& command) {
  if (command.forces.size() != command.ids.size()) {
    return Refuse(Reason::kInvalidValue, "forces", "forces has not as many rows as entity_ids");
  }
  if (!command.torques.empty() && command.torques.size() != command.ids.size()) {
    return Refuse(Reason::kInvalidValue, "torques", "torques has not as many rows as entity_ids");
  }
  for (size_t i = 0; i < command.ids.size(); ++i) {
    const Status status = CheckDynamic(command.ids[i], "entity_ids");
    if (!status.ok()) return CheckDynamic(command.ids[i], Cat("entity_ids[", i, "]"));
  }
  GENPHYS_RETURN_IF_ERROR(CheckPending(command.ids.size(), "entity_ids"));
  GENPHYS_RETURN_IF_ERROR(CheckColumn(command.forces, "forces"));
  return CheckColumn(command.torques, "torques");
}

EntityDesc Merged(const EntityDesc& current, const UpdateEntity& update) {
  EntityDesc merged = current;
  const EntityFields& fields = update.fields;
  const EntityDesc& given = update.entity;
  if (fields.Has(EntityField::kDisplayName)) merged.display_name = given.display_name;
  if (fields.Has(EntityField::kPose)) merged.pose = given.pose;
  if (fields.Has(EntityField::kVisual)) merged.visual = given.visual;
  if (fields.Has(EntityField::kRigidBody)) merged.rigid_body = given.rigid_body;
  if (!merged.rigid_body || (fields.bits & kBodyParts) == 0) return merged;
  const RigidBody from = given.rigid_body.value_or(RigidBody{});
  RigidBody& to = *merged.rigid_body;
  if (fields.Has(EntityField::kMotionType)) {
    to.motion_type = from.motion_type;
    if (to.motion_type == MotionType::kStatic) to.linear_velocity = to.angular_velocity = Vector3::Zero();
  }
  if (fields.Has(EntityField::kGeometries)) to.geometries = from.geometries;
  if (fields.Has(EntityField::kInertia)) to.inertia = from.inertia;
  if (fields.Has(EntityField::kAutoDisable)) to.auto_disable = from.auto_disable;
  if (fields.Has(EntityField::kLinearVelocity)) to.linear_velocity = from.linear_velocity;
  if (fields.Has(EntityField::kAngularVelocity)) to.angular_velocity = from.angular_velocity;
  if (fields.Has(EntityField::kLinearDamping)) to.linear_damping = from.linear_damping;
  if (fields.Has(EntityField::kAngularDamping)) to.angular_damping = from.angular_damping;
  if (fields.Has(EntityField::kGravityScale)) to.gravity_scale = from.gravity_scale;
  if (fields.Has(EntityField::kLinearSpeedMax)) to.linear_speed_max = from.linear_speed_max;
  if (fields.Has(EntityField::kAngularSpeedMax)) to.angular_speed_max = from.angular_speed_max;
  if (fields.Has(EntityField::kLockedAxes)) to.locked_axes = from.locked_axes;
  if (fields.Has(EntityField::kErrorCorrection)) to.error_correction = from.error_correction;
  if (fields.Has(EntityField::kIgnoredEntities)) to.ignored_entities = from.ignored_entities;
  return merged;
}

}  // namespace genphys

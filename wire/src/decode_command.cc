#include <optional>
#include <string>
#include <utility>

#include "enums.h"
#include "genphys/limits.h"
#include "genphys/wire/decode.h"
#include "joint_mask.h"
#include "update_mask.h"
#include "values.h"

namespace genphys {
namespace {

std::optional<Vector3> DecodeIf(bool set, const v1::Vector3& v) {
  return set ? std::optional<Vector3>(DecodeVector(v)) : std::nullopt;
}

Result<Command> Decode(const v1::CreateEntity& command) {
  Result<CreateEntity> create = DecodeCreate(command.entity());
  if (!create.ok()) return WithFieldPrefix(create.status(), "entity");
  return *std::move(create);
}

Result<Command> Decode(const v1::UpdateEntity& command) {
  Result<EntityDesc> entity = DecodeEntity(command.entity());
  if (!entity.ok()) return WithFieldPrefix(entity.status(), "entity");
  EntityFields fields = PopulatedFields(command.entity());
  if (command.update_mask().paths_size() > 0) {
    const Result<EntityFields> named = DecodeMask(command.update_mask());
    if (!named.ok()) return named.status();
    fields = *named;
  }
  return UpdateEntity{EntityId::FromPacked(command.entity().id()), *std::move(entity), fields};
}

Result<Command> Decode(const v1::DeleteEntity& command) {
  return DeleteEntity{EntityId::FromPacked(command.entity_id())};
}

Result<Command> Decode(const v1::ApplyForce& command) {
  Result<ApplyForce> force = DecodeForce(command);
  if (!force.ok()) return force.status();
  return *std::move(force);
}

Result<Command> Decode(const v1::ApplyImpulse& command) {
  return ApplyImpulse{.id = EntityId::FromPacked(command.entity_id()),
                      .linear = DecodeVector(command.linear()),
                      .angular = DecodeVector(command.angular()),
                      .point = DecodeIf(command.has_point(), command.point()),
                      .coordinates = DecodeCoordinates(command.coordinates())};
}

Result<Command> Decode(const v1::SetVelocity& command) {
  return SetVelocity{EntityId::FromPacked(command.entity_id()), DecodeIf(command.has_linear(), command.linear()),
                     DecodeIf(command.has_angular(), command.angular())};
}

Result<Command> Decode(const v1::SetPose& command) {
  SetPose decoded{.id = EntityId::FromPacked(command.entity_id()),
                  .position = DecodeIf(command.pose().has_position(), command.pose().position())};
  if (command.pose().has_orientation()) decoded.orientation = DecodeQuaternion(command.pose().orientation());
  decoded.over_steps = command.over_steps();
  return decoded;
}

Result<Command> Decode(const v1::SetGravity& command) { return SetGravity{DecodeVector(command.gravity())}; }

Result<Command> Decode(const v1::SetStepper& command) { return SetStepper{DecodeStepper(command.stepper())}; }

Result<Command> Decode(const v1::SetEngine& command) {
  Result<std::string> engine = DecodeEngineName(command.engine());
  if (!engine.ok()) return engine.status();
  return SetEngine{*std::move(engine)};
}

Result<Command> Decode(const v1::ApplyForceColumns& command) {
  ApplyForceColumns decoded{.ids = DecodeIds(command.entity_ids()),
                            .forces = DecodeColumn<Vector3>(command.forces()),
                            .torques = DecodeColumn<Vector3>(command.torques()),
                            .sampled = command.sampled()};
  // The model always has forces; leaving them out is a way of writing that belongs to the wire.
  if (command.forces().empty()) decoded.forces.assign(decoded.ids.size(), Vector3::Zero());
  return decoded;
}

Result<Command> Decode(const v1::CreateJoint& command) {
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckNoId(command.joint().id()), "joint"));
  Result<JointDesc> joint = DecodeJoint(command.joint());
  if (!joint.ok()) return WithFieldPrefix(joint.status(), "joint");
  return CreateJoint{*std::move(joint)};
}

Result<Command> Decode(const v1::UpdateJoint& command) {
  JointFields fields = PopulatedFields(command.joint());
  if (command.update_mask().paths_size() > 0) {
    const Result<JointFields> named = DecodeJointMask(command.joint(), command.update_mask());
    if (!named.ok()) return named.status();
    fields = *named;
  }
  Result<JointDesc> joint = DecodeJoint(command.joint());
  if (!joint.ok()) return WithFieldPrefix(joint.status(), "joint");
  return UpdateJoint{JointId::FromPacked(command.joint().id()), *std::move(joint), fields};
}

Result<Command> Decode(const v1::DeleteJoint& command) { return DeleteJoint{JointId::FromPacked(command.joint_id())}; }

Result<Command> Decode(const v1::SetMotorColumns& command) {
  return SetMotorColumns{.ids = DecodeColumn<JointId>(command.joint_ids()),
                         .velocities = DecodeColumn<double>(command.targets()),
                         .positions = DecodeColumn<double>(command.positions())};
}

Result<Command> Decode(const v1::CreateForceField& command) {
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckNoId(command.field().id()), "field"));
  Result<ForceField> field = DecodeForceField(command.field());
  if (!field.ok()) return WithFieldPrefix(field.status(), "field");
  CreateForceField decoded{*std::move(field),
                           {command.created_by_commands().begin(), command.created_by_commands().end()}};
  if (command.has_spring_a_created_by_command()) {
    decoded.spring_a_created_by_command = command.spring_a_created_by_command();
  }
  if (command.has_spring_b_created_by_command()) {
    decoded.spring_b_created_by_command = command.spring_b_created_by_command();
  }
  return decoded;
}

Result<Command> Decode(const v1::UpdateForceField& command) {
  Result<ForceField> field = DecodeForceField(command.field());
  if (!field.ok()) return WithFieldPrefix(field.status(), "field");
  return UpdateForceField{command.field().id(), *std::move(field)};
}

Result<Command> Decode(const v1::DeleteForceField& command) { return DeleteForceField{command.field_id()}; }

template <typename Message>
Result<Command> DecodeUnder(std::string_view name, const Message& message) {
  Result<Command> decoded = Decode(message);
  if (!decoded.ok()) return WithFieldPrefix(decoded.status(), name);
  return decoded;
}

// No world has room for more than that, so that what brings more need not be made first.
Status CheckGeometries(const google::protobuf::RepeatedPtrField<v1::Command>& commands) {
  size_t count = 0;
  for (int i = 0; i < commands.size(); ++i) {
    const bool creates = commands[i].has_create_entity();
    const v1::Entity& entity = creates ? commands[i].create_entity().entity() : commands[i].update_entity().entity();
    count += static_cast<size_t>(entity.rigid_body().geometries_size());
    if (count <= Limits::kWorldGeometriesMax) continue;
    return Refuse(
        Reason::kLimitExceeded,
        "commands[" + std::to_string(i) + (creates ? "].create_entity" : "].update_entity") +
            ".entity.rigid_body.geometries",
        "a world holds " + std::to_string(Limits::kWorldGeometriesMax) + " geometries, and a batch brings no more");
  }
  return absl::OkStatus();
}

}  // namespace

Result<ApplyForce> DecodeForce(const v1::ApplyForce& force) {
  return ApplyForce{.id = EntityId::FromPacked(force.entity_id()),
                    .force = DecodeVector(force.force()),
                    .torque = DecodeVector(force.torque()),
                    .point = DecodeIf(force.has_point(), force.point()),
                    .coordinates = DecodeCoordinates(force.coordinates()),
                    .steps = force.has_steps() ? force.steps() : 1,
                    .replace = force.replace(),
                    .sampled = force.sampled()};
}

Result<Command> DecodeCommand(const v1::Command& command) {
  switch (command.kind_case()) {
    case v1::Command::kCreateEntity:
      return DecodeUnder("create_entity", command.create_entity());
    case v1::Command::kUpdateEntity:
      return DecodeUnder("update_entity", command.update_entity());
    case v1::Command::kDeleteEntity:
      return DecodeUnder("delete_entity", command.delete_entity());
    case v1::Command::kCreateJoint:
      return DecodeUnder("create_joint", command.create_joint());
    case v1::Command::kUpdateJoint:
      return DecodeUnder("update_joint", command.update_joint());
    case v1::Command::kDeleteJoint:
      return DecodeUnder("delete_joint", command.delete_joint());
    case v1::Command::kApplyForce:
      return DecodeUnder("apply_force", command.apply_force());
    case v1::Command::kApplyImpulse:
      return DecodeUnder("apply_impulse", command.apply_impulse());
    case v1::Command::kSetVelocity:
      return DecodeUnder("set_velocity", command.set_velocity());
    case v1::Command::kSetPose:
      return DecodeUnder("set_pose", command.set_pose());
    case v1::Command::kSetGravity:
      return DecodeUnder("set_gravity", command.set_gravity());
    case v1::Command::kSetStepper:
      return DecodeUnder("set_stepper", command.set_stepper());
    case v1::Command::kSetEngine:
      return DecodeUnder("set_engine", command.set_engine());
    case v1::Command::kApplyForces:
      return DecodeUnder("apply_forces", command.apply_forces());
    case v1::Command::kSetMotors:
      return DecodeUnder("set_motors", command.set_motors());
    case v1::Command::kCreateForceField:
      return DecodeUnder("create_force_field", command.create_force_field());
    case v1::Command::kUpdateForceField:
      return DecodeUnder("update_force_field", command.update_force_field());
    case v1::Command::kDeleteForceField:
      return DecodeUnder("delete_force_field", command.delete_force_field());
    case v1::Command::KIND_NOT_SET:
      break;
  }
  return Refuse(Reason::kMissingField, "kind", "a command says which change it is");
}

Result<std::vector<Command>> DecodeCommands(const google::protobuf::RepeatedPtrField<v1::Command>& commands) {
  GENPHYS_RETURN_IF_ERROR(CheckGeometries(commands));
  std::vector<Command> decoded;
  decoded.reserve(static_cast<size_t>(commands.size()));
  for (int i = 0; i < commands.size(); ++i) {
    Result<Command> command = DecodeCommand(commands[i]);
    if (!command.ok()) return WithFieldPrefix(command.status(), "commands[" + std::to_string(i) + "]");
    decoded.push_back(*std::move(command));
  }
  return decoded;
}

std::vector<EntityId> DecodeIds(std::string_view column) { return DecodeColumn<EntityId>(column); }

}  // namespace genphys

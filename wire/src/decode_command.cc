#include <optional>
#include <string>
#include <utility>

#include "enums.h"
#include "genphys/wire/decode.h"
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
                            .torques = DecodeColumn<Vector3>(command.torques())};
  // The model always has forces; leaving them out is a way of writing that belongs to the wire.
  if (command.forces().empty()) decoded.forces.assign(decoded.ids.size(), Vector3::Zero());
  return decoded;
}

Status Refused(const v1::Joint& joint) {
  switch (joint.kind_case()) {
    case v1::Joint::kBall:
      return NowhereSupported(Feature::kJointBall, "ball");
    case v1::Joint::kHinge:
      return NowhereSupported(Feature::kJointHinge, "hinge");
    case v1::Joint::kSlider:
      return NowhereSupported(Feature::kJointSlider, "slider");
    case v1::Joint::kUniversal:
      return NowhereSupported(Feature::kJointUniversal, "universal");
    case v1::Joint::kFixed:
      return NowhereSupported(Feature::kJointFixed, "fixed");
    case v1::Joint::KIND_NOT_SET:
      break;
  }
  return Refuse(Reason::kMissingField, "kind", "a joint says what it leaves free");
}

Result<Command> Decode(const v1::CreateJoint& command) { return WithFieldPrefix(Refused(command.joint()), "joint"); }

Result<Command> Decode(const v1::UpdateJoint& command) { return WithFieldPrefix(Refused(command.joint()), "joint"); }

Result<Command> Decode(const v1::DeleteJoint&) {
  return Refuse(Reason::kUnsupportedFeature, "joint_id", "no engine of this server supports joints");
}

Result<Command> Decode(const v1::SetMotorColumns&) {
  return Refuse(Reason::kUnsupportedFeature, "joint_ids", "no engine of this server supports the motors of joints");
}

template <typename Message>
Result<Command> DecodeUnder(std::string_view name, const Message& message) {
  Result<Command> decoded = Decode(message);
  if (!decoded.ok()) return WithFieldPrefix(decoded.status(), name);
  return decoded;
}

}  // namespace

Result<ApplyForce> DecodeForce(const v1::ApplyForce& force) {
  return ApplyForce{.id = EntityId::FromPacked(force.entity_id()),
                    .force = DecodeVector(force.force()),
                    .torque = DecodeVector(force.torque()),
                    .point = DecodeIf(force.has_point(), force.point()),
                    .coordinates = DecodeCoordinates(force.coordinates()),
                    .steps = force.has_steps() ? force.steps() : 1,
                    .replace = force.replace()};
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
    case v1::Command::KIND_NOT_SET:
      break;
  }
  return Refuse(Reason::kMissingField, "kind", "a command says which change it is");
}

Result<std::vector<Command>> DecodeCommands(const google::protobuf::RepeatedPtrField<v1::Command>& commands) {
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

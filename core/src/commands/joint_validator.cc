// What a batch may do to joints.
#include <cmath>
#include <utility>

#include "commands/command_validator.h"
#include "genphys/limits.h"
#include "genphys/world.h"
#include "joints/check_joint.h"
#include "model/cat.h"
#include "model/validate.h"

namespace genphys {
namespace {

bool TurnsFirst(const JointKind& kind) {
  struct Visitor {
    bool operator()(const SliderJoint&) const { return false; }
    bool operator()(const DistanceJoint&) const { return false; }
    bool operator()(const SixDofJoint& joint) const {
      for (const std::optional<JointAxis>& axis : joint.along) {
        if (axis && axis->motor) return false;
      }
      return true;
    }
    bool operator()(const WheelJoint& joint) const {
      return joint.spin.motor || (joint.steering && joint.steering->motor);
    }
    bool operator()(const BallJoint&) const { return true; }
    bool operator()(const HingeJoint&) const { return true; }
    bool operator()(const UniversalJoint&) const { return true; }
    bool operator()(const FixedJoint&) const { return true; }
    bool operator()(const GearJoint&) const { return true; }
  };
  return std::visit(Visitor{}, kind);
}

}  // namespace

Result<JointDesc> CommandValidator::Find(JointId id, std::string_view field) const {
  const auto gone = [&] {
    return Refuse(Reason::kStaleId, field, Cat("joint ", id.packed(), " is deleted earlier in this batch"));
  };
  const auto changed = changed_joints_.find(id);
  if (changed != changed_joints_.end() && !changed->second) return gone();
  GENPHYS_RETURN_IF_ERROR(world_.CheckId(id, field));
  const JointDesc& joint =
      changed != changed_joints_.end() ? *changed->second : world_.scene().joints[id.index()]->desc;
  for (const EntityRef* entity : {&joint.entity_a, &joint.entity_b}) {
    const auto end = changed_.find(entity->id);
    if (end != changed_.end() && end->second == nullptr) return gone();
  }
  return joint;
}

Result<const EntityDesc*> CommandValidator::Find(const EntityRef& entity, std::string_view field) const {
  if (!entity.created_by_command) return Find(entity.id, Cat(field, ".id"));
  const uint32_t place = *entity.created_by_command;
  if (place < made_.size() && made_[place] != nullptr) return made_[place].get();
  return Refuse(Reason::kInvalidValue, Cat(field, ".created_by_command"),
                Cat("command ", place, " of this batch creates no entity before this one"));
}

Status CommandValidator::CheckEnds(const JointDesc& joint) const {
  if (joint.entity_a.is_world() && joint.entity_b.is_world()) {
    return Refuse(Reason::kMissingField, "entity_a", "a joint needs an entity on at least one side");
  }
  const EntityDesc* a = nullptr;
  const EntityDesc* b = nullptr;
  for (const auto& [entity, name, desc] :
       {std::tuple(&joint.entity_a, "entity_a", &a), std::tuple(&joint.entity_b, "entity_b", &b)}) {
    if (entity->is_world()) continue;
    const Result<const EntityDesc*> found = Find(*entity, name);
    if (!found.ok()) return found.status();
    *desc = *found;
  }
  if (joint.entity_a == joint.entity_b) {
    return Refuse(Reason::kInvalidValue, "entity_b", "a joint cannot join an entity to itself");
  }
  if ((a != nullptr && IsDynamic(*a)) || (b != nullptr && IsDynamic(*b))) return absl::OkStatus();
  return Refuse(Reason::kInvalidValue, joint.entity_b.is_world() ? "entity_a" : "entity_b",
                "neither side is dynamic: there is nothing that the joint could hold");
}

Status CommandValidator::CheckFeature(const JointKind& kind) const {
  const Feature feature = FeatureOf(kind);
  const Backend* backend = world_.registry_.Find(settings_.engine);
  if (backend != nullptr && backend->capabilities().Has(feature)) return absl::OkStatus();
  return UnsupportedFeature(feature, settings_.engine, NameOf(kind));
}

Status CommandValidator::operator()(const CreateJoint& command) {
  if (world_.joint_count() + ++created_joints_ > Limits::kJointsMax) {
    return Refuse(Reason::kLimitExceeded, "joint", Cat("a world holds ", Limits::kJointsMax, " joints"));
  }
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckJoint(command.joint), "joint"));
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckEnds(command.joint), "joint"));
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckFeature(command.joint.kind), "joint"));
  kinds_.push_back(command.joint.kind);
  return absl::OkStatus();
}

Status CommandValidator::operator()(const UpdateJoint& command) {
  const Result<JointDesc> current = Find(command.id, "joint.id");
  if (!current.ok()) return current.status();
  Result<JointDesc> merged = Merged(*current, command.joint, command.fields);
  if (!merged.ok()) return WithFieldPrefix(merged.status(), "joint");
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckJoint(*merged), "joint"));
  if (merged->kind.index() != current->kind.index()) {
    GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckFeature(merged->kind), "joint"));
  }
  kinds_.push_back(merged->kind);
  changed_joints_[command.id] = *std::move(merged);
  return absl::OkStatus();
}

Status CommandValidator::operator()(const DeleteJoint& command) {
  const Result<JointDesc> current = Find(command.id, "joint_id");
  if (!current.ok()) return current.status();
  changed_joints_[command.id] = std::nullopt;
  return absl::OkStatus();
}

Status CommandValidator::CheckMotor(JointId id, double velocity, const double* position) const {
  Result<JointDesc> joint = Find(id, "joint_ids");
  if (!joint.ok()) return joint.status();
  const Motor* motor = FirstMotor(joint->kind);
  if (motor == nullptr) {
    return Refuse(Reason::kInvalidValue, "joint_ids", Cat("joint ", id.packed(), " has no motor"));
  }
  const bool turns = TurnsFirst(joint->kind);
  const double rate_max = turns ? Limits::kSpinMax : Limits::kSpeedMax;
  GENPHYS_RETURN_IF_ERROR(CheckNumber(velocity, -rate_max, rate_max, "targets"));
  if (position == nullptr) return absl::OkStatus();
  if (!motor->target_position) {
    return Refuse(Reason::kInvalidValue, "joint_ids",
                  Cat("the motor of joint ", id.packed(), " drives to no position"));
  }
  const double position_max = turns ? Limits::kJointAngleMax : Limits::kPositionMax;
  return CheckNumber(*position, -position_max, position_max, "positions");
}

Status CommandValidator::operator()(const SetMotorColumns& command) {
  if (command.velocities.size() != command.ids.size()) {
    return Refuse(Reason::kInvalidValue, "targets", "targets has not as many rows as joint_ids");
  }
  if (!command.positions.empty() && command.positions.size() != command.ids.size()) {
    return Refuse(Reason::kInvalidValue, "positions", "positions has not as many rows as joint_ids");
  }
  for (size_t i = 0; i < command.ids.size(); ++i) {
    const double* position = command.positions.empty() ? nullptr : &command.positions[i];
    const Status status = CheckMotor(command.ids[i], command.velocities[i], position);
    if (const std::optional<Refusal> refusal = RefusalOf(status)) {
      return Refuse(refusal->reason, Cat(refusal->field, "[", i, "]"), MessageOf(status));
    }
  }
  return absl::OkStatus();
}

}  // namespace genphys

#include <optional>

#include "enums.h"
#include "genphys/wire/encode.h"
#include "joint_mask.h"
#include "update_mask.h"
#include "values.h"

namespace genphys {
namespace {

struct CommandEncoder {
  v1::Command* out;

  void operator()(const CreateEntity& command) const {
    EncodeEntity(EntityId(), command.entity, out->mutable_create_entity()->mutable_entity());
  }

  void operator()(const UpdateEntity& command) const {
    v1::UpdateEntity* update = out->mutable_update_entity();
    update->mutable_entity()->set_id(command.id.packed());
    // Without paths everything that the entity sets would change, so it sets nothing.
    if (command.fields.bits == 0) return;
    EncodeEntity(command.id, command.entity, update->mutable_entity());
    EncodeMask(command.fields, update->mutable_update_mask());
  }

  void operator()(const DeleteEntity& command) const {
    out->mutable_delete_entity()->set_entity_id(command.id.packed());
  }

  void operator()(const ApplyForce& command) const {
    v1::ApplyForce* force = out->mutable_apply_force();
    force->set_entity_id(command.id.packed());
    EncodeVector(command.force, force->mutable_force());
    EncodeVector(command.torque, force->mutable_torque());
    if (command.point) EncodeVector(*command.point, force->mutable_point());
    force->set_coordinates(EncodeCoordinates(command.coordinates));
    force->set_steps(command.steps);
    force->set_replace(command.replace);
    force->set_sampled(command.sampled);
  }

  void operator()(const ApplyImpulse& command) const {
    v1::ApplyImpulse* impulse = out->mutable_apply_impulse();
    impulse->set_entity_id(command.id.packed());
    EncodeVector(command.linear, impulse->mutable_linear());
    EncodeVector(command.angular, impulse->mutable_angular());
    if (command.point) EncodeVector(*command.point, impulse->mutable_point());
    impulse->set_coordinates(EncodeCoordinates(command.coordinates));
  }

  void operator()(const SetVelocity& command) const {
    v1::SetVelocity* velocity = out->mutable_set_velocity();
    velocity->set_entity_id(command.id.packed());
    if (command.linear) EncodeVector(*command.linear, velocity->mutable_linear());
    if (command.angular) EncodeVector(*command.angular, velocity->mutable_angular());
  }

  void operator()(const SetPose& command) const {
    out->mutable_set_pose()->set_entity_id(command.id.packed());
    out->mutable_set_pose()->set_over_steps(command.over_steps);
    v1::Pose* pose = out->mutable_set_pose()->mutable_pose();
    if (command.position) EncodeVector(*command.position, pose->mutable_position());
    if (command.orientation) EncodeQuaternion(*command.orientation, pose->mutable_orientation());
  }

  void operator()(const SetGravity& command) const {
    EncodeVector(command.gravity, out->mutable_set_gravity()->mutable_gravity());
  }

  void operator()(const SetStepper& command) const {
    EncodeStepper(command.stepper, out->mutable_set_stepper()->mutable_stepper());
  }

  void operator()(const SetEngine& command) const {
    out->mutable_set_engine()->set_engine(EncodeEngineName(command.engine));
  }

  void operator()(const ApplyForceColumns& command) const {
    v1::ApplyForceColumns* columns = out->mutable_apply_forces();
    EncodeColumn(command.ids, columns->mutable_entity_ids());
    EncodeColumn(command.forces, columns->mutable_forces());
    EncodeColumn(command.torques, columns->mutable_torques());
    columns->set_sampled(command.sampled);
  }

  void operator()(const CreateJoint& command) const {
    EncodeJoint(JointId(), command.joint, out->mutable_create_joint()->mutable_joint());
  }

  void operator()(const UpdateJoint& command) const {
    v1::UpdateJoint* update = out->mutable_update_joint();
    EncodeJoint(command.id, command.joint, update->mutable_joint());
    EncodeJointMask(command.joint.kind, command.fields, update->mutable_update_mask());
  }

  void operator()(const DeleteJoint& command) const { out->mutable_delete_joint()->set_joint_id(command.id.packed()); }

  void operator()(const SetMotorColumns& command) const {
    v1::SetMotorColumns* columns = out->mutable_set_motors();
    EncodeColumn(command.ids, columns->mutable_joint_ids());
    EncodeColumn(command.velocities, columns->mutable_targets());
    EncodeColumn(command.positions, columns->mutable_positions());
  }

  void operator()(const CreateForceField& command) const {
    v1::CreateForceField* create = out->mutable_create_force_field();
    EncodeForceField(0, command.field, create->mutable_field());
    for (const uint32_t place : command.created_by_commands) create->add_created_by_commands(place);
    if (command.spring_a_created_by_command) {
      create->set_spring_a_created_by_command(*command.spring_a_created_by_command);
    }
    if (command.spring_b_created_by_command) {
      create->set_spring_b_created_by_command(*command.spring_b_created_by_command);
    }
  }

  void operator()(const UpdateForceField& command) const {
    EncodeForceField(command.id, command.field, out->mutable_update_force_field()->mutable_field());
  }

  void operator()(const DeleteForceField& command) const {
    out->mutable_delete_force_field()->set_field_id(command.id);
  }
};

}  // namespace

void EncodeCommand(const Command& command, v1::Command* out) { std::visit(CommandEncoder{out}, command); }

}  // namespace genphys

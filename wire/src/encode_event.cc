#include "genphys/wire/encode.h"
#include "joint_mask.h"
#include "shape_message.h"
#include "update_mask.h"
#include "values.h"

namespace genphys {
namespace {

struct EventEncoder {
  v1::Event* out;
  bool contact_points;

  template <typename Message>
  static void EncodePair(const EntityPair& pair, Message* message) {
    message->set_entity_a(pair.a.packed());
    message->set_entity_b(pair.b.packed());
  }
  template <typename Message>
  void EncodePoints(const std::vector<EventContactPoint>& points, Message* message) const {
    if (!contact_points) return;
    for (const EventContactPoint& point : points) EncodePoint(point, message->add_points());
  }
  template <typename Kind, typename Message>
  static void EncodeSensor(const Kind& kind, Message* message) {
    message->set_sensor_entity(kind.sensor.packed());
    message->set_visitor_entity(kind.visitor.packed());
  }
  template <typename Kind, typename Message>
  static void EncodeMotion(const Kind& kind, Message* message) {
    message->set_entity_id(kind.id.packed());
    message->set_rotation(kind.rotation);
  }

  void operator()(const EntityCreated& kind) const {
    EncodeEntity(kind.id, *kind.entity, out->mutable_entity_created()->mutable_entity());
  }
  void operator()(const EntityUpdated& kind) const {
    EncodeEntity(kind.id, *kind.entity, out->mutable_entity_updated()->mutable_entity());
    EncodeMask(kind.fields, out->mutable_entity_updated()->mutable_changed());
  }
  void operator()(const EntityDeleted& kind) const { out->mutable_entity_deleted()->set_entity_id(kind.id.packed()); }
  void operator()(const ContactBegan& kind) const {
    EncodePair(kind.pair, out->mutable_contact_began());
    EncodePoints(kind.points, out->mutable_contact_began());
  }
  void operator()(const ContactPersisted& kind) const {
    EncodePair(kind.pair, out->mutable_contact_persisted());
    EncodePoints(kind.points, out->mutable_contact_persisted());
  }
  void operator()(const ContactEnded& kind) const { EncodePair(kind.pair, out->mutable_contact_ended()); }
  void operator()(const SensorEntered& kind) const { EncodeSensor(kind, out->mutable_sensor_entered()); }
  void operator()(const SensorLeft& kind) const { EncodeSensor(kind, out->mutable_sensor_left()); }
  void operator()(const EntityWoke& kind) const { out->mutable_entity_woke()->set_entity_id(kind.id.packed()); }
  void operator()(const EntitySlept& kind) const { out->mutable_entity_slept()->set_entity_id(kind.id.packed()); }
  void operator()(const EntityStartedMoving& kind) const { EncodeMotion(kind, out->mutable_entity_started_moving()); }
  void operator()(const EntityStoppedMoving& kind) const { EncodeMotion(kind, out->mutable_entity_stopped_moving()); }
  void operator()(const EntityFaulted& kind) const { out->mutable_entity_faulted()->set_entity_id(kind.id.packed()); }
  void operator()(const JointBroke& kind) const {
    v1::JointBroke* const message = out->mutable_joint_broke();
    message->set_joint_id(kind.joint.packed());
    message->set_force(kind.force);
    message->set_torque(kind.torque);
    EncodePair(kind.pair, message);
  }
  void operator()(const JointCreated& kind) const {
    EncodeJoint(kind.joint, *kind.desc, out->mutable_joint_created()->mutable_joint());
  }
  void operator()(const JointUpdated& kind) const {
    EncodeJoint(kind.joint, *kind.desc, out->mutable_joint_updated()->mutable_joint());
    EncodeJointMask(kind.desc->kind, kind.fields, out->mutable_joint_updated()->mutable_changed());
  }
  void operator()(const JointDeleted& kind) const {
    out->mutable_joint_deleted()->set_joint_id(kind.joint.packed());
    EncodePair(kind.pair, out->mutable_joint_deleted());
  }
  void operator()(const ForceFieldCreated& kind) const {
    EncodeForceField(kind.field, *kind.desc, out->mutable_force_field_created()->mutable_field());
  }
  void operator()(const ForceFieldUpdated& kind) const {
    EncodeForceField(kind.field, *kind.desc, out->mutable_force_field_updated()->mutable_field());
  }
  void operator()(const ForceFieldDeleted& kind) const { out->mutable_force_field_deleted()->set_field_id(kind.field); }
};

}  // namespace

void EncodePoint(const EventContactPoint& point, v1::ContactPoint* out) {
  EncodeVector(point.position, out->mutable_position());
  EncodeVector(point.normal, out->mutable_normal());
  out->set_depth(point.depth);
  out->set_normal_impulse(point.normal_impulse);
  EncodeVector(point.friction_impulse, out->mutable_friction_impulse());
  EncodeVector(point.relative_velocity, out->mutable_relative_velocity());
  out->set_friction(point.friction);
  out->set_restitution(point.restitution);
  out->set_geometry_a(point.geometry_a);
  out->set_geometry_b(point.geometry_b);
}

void EncodeEvent(const Event& event, v1::Event* out, bool contact_points) {
  out->set_sequence(event.sequence);
  out->set_step(event.step);
  std::visit(EventEncoder{out, contact_points}, event.kind);
}

}  // namespace genphys

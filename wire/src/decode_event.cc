#include <memory>
#include <string>
#include <utility>

#include "genphys/wire/decode.h"
#include "joint_mask.h"
#include "shape_message.h"
#include "update_mask.h"
#include "values.h"

namespace genphys {
namespace {

template <typename Message>
EntityId IdOf(const Message& message) {
  return EntityId::FromPacked(message.entity_id());
}

template <typename Message>
EntityPair PairOf(const Message& message) {
  return {EntityId::FromPacked(message.entity_a()), EntityId::FromPacked(message.entity_b())};
}

template <typename Kind, typename Message>
Kind DecodeSensor(const Message& message) {
  return {EntityId::FromPacked(message.sensor_entity()), EntityId::FromPacked(message.visitor_entity())};
}

template <typename Message>
std::vector<EventContactPoint> PointsOf(const Message& message) {
  std::vector<EventContactPoint> points;
  points.reserve(static_cast<size_t>(message.points_size()));
  for (const v1::ContactPoint& point : message.points()) {
    points.push_back(DecodePoint(point));
  }
  return points;
}

Result<EventKind> Decode(const v1::EntityCreated& created) {
  Result<EntityDesc> entity = DecodeEntity(created.entity());
  if (!entity.ok()) return WithFieldPrefix(entity.status(), "entity_created.entity");
  return EntityCreated{EntityId::FromPacked(created.entity().id()),
                       std::make_shared<const EntityDesc>(*std::move(entity))};
}

Result<EventKind> Decode(const v1::EntityUpdated& updated) {
  Result<EntityDesc> entity = DecodeEntity(updated.entity());
  if (!entity.ok()) return WithFieldPrefix(entity.status(), "entity_updated.entity");
  const Result<EntityFields> fields = DecodeMask(updated.changed());
  if (!fields.ok()) return WithFieldPrefix(fields.status(), "entity_updated");
  return EntityUpdated{EntityId::FromPacked(updated.entity().id()),
                       std::make_shared<const EntityDesc>(*std::move(entity)), *fields};
}

// Of one that is told of: both sides are named by id, or are the world.
EntityPair PairOf(const JointDesc& joint) { return {joint.entity_a.id, joint.entity_b.id}; }

EntityPair PairOf(const ForceField& field) {
  const auto* spring = std::get_if<SpringField>(&field.kind);
  return spring != nullptr ? EntityPair{spring->a, spring->b} : EntityPair{};
}

Result<EventKind> Decode(const v1::JointCreated& created) {
  Result<JointDesc> joint = DecodeJoint(created.joint());
  if (!joint.ok()) return WithFieldPrefix(joint.status(), "joint_created.joint");
  return JointCreated{JointId::FromPacked(created.joint().id()), PairOf(*joint),
                      std::make_shared<const JointDesc>(*joint)};
}

Result<EventKind> Decode(const v1::JointUpdated& updated) {
  Result<JointDesc> joint = DecodeJoint(updated.joint());
  if (!joint.ok()) return WithFieldPrefix(joint.status(), "joint_updated.joint");
  const Result<JointFields> fields = DecodeJointMask(updated.joint(), updated.changed());
  if (!fields.ok()) return WithFieldPrefix(fields.status(), "joint_updated");
  return JointUpdated{JointId::FromPacked(updated.joint().id()), PairOf(*joint),
                      std::make_shared<const JointDesc>(*joint), *fields};
}

template <typename Kind>
Result<EventKind> DecodeField(const v1::ForceField& message) {
  const Result<ForceField> field = DecodeForceField(message);
  if (!field.ok()) return WithFieldPrefix(field.status(), "field");
  return Kind{message.id(), PairOf(*field), std::make_shared<const ForceField>(*field)};
}

Result<EventKind> DecodeKind(const v1::Event& event) {
  switch (event.kind_case()) {
    case v1::Event::kEntityCreated:
      return Decode(event.entity_created());
    case v1::Event::kEntityUpdated:
      return Decode(event.entity_updated());
    case v1::Event::kEntityDeleted:
      return EntityDeleted{IdOf(event.entity_deleted())};
    case v1::Event::kContactBegan:
      return ContactBegan{PairOf(event.contact_began()), PointsOf(event.contact_began())};
    case v1::Event::kContactPersisted:
      return ContactPersisted{PairOf(event.contact_persisted()), PointsOf(event.contact_persisted())};
    case v1::Event::kContactEnded:
      return ContactEnded{PairOf(event.contact_ended())};
    case v1::Event::kSensorEntered:
      return DecodeSensor<SensorEntered>(event.sensor_entered());
    case v1::Event::kSensorLeft:
      return DecodeSensor<SensorLeft>(event.sensor_left());
    case v1::Event::kEntityWoke:
      return EntityWoke{IdOf(event.entity_woke())};
    case v1::Event::kEntitySlept:
      return EntitySlept{IdOf(event.entity_slept())};
    case v1::Event::kEntityStartedMoving:
      return EntityStartedMoving{IdOf(event.entity_started_moving()), event.entity_started_moving().rotation()};
    case v1::Event::kEntityStoppedMoving:
      return EntityStoppedMoving{IdOf(event.entity_stopped_moving()), event.entity_stopped_moving().rotation()};
    case v1::Event::kEntityFaulted:
      return EntityFaulted{IdOf(event.entity_faulted())};
    case v1::Event::kJointBroke:
      return JointBroke{JointId::FromPacked(event.joint_broke().joint_id()), PairOf(event.joint_broke()),
                        event.joint_broke().force(), event.joint_broke().torque()};
    case v1::Event::kJointCreated:
      return Decode(event.joint_created());
    case v1::Event::kJointUpdated:
      return Decode(event.joint_updated());
    case v1::Event::kJointDeleted:
      return JointDeleted{JointId::FromPacked(event.joint_deleted().joint_id()), PairOf(event.joint_deleted())};
    case v1::Event::kForceFieldCreated:
      return DecodeField<ForceFieldCreated>(event.force_field_created().field());
    case v1::Event::kForceFieldUpdated:
      return DecodeField<ForceFieldUpdated>(event.force_field_updated().field());
    case v1::Event::kForceFieldDeleted:
      return ForceFieldDeleted{event.force_field_deleted().field_id(), {}};
    case v1::Event::KIND_NOT_SET:
      break;
  }
  return Refuse(Reason::kInvalidValue, "kind", "event " + std::to_string(event.sequence()) + " is of an unknown kind");
}

}  // namespace

EventContactPoint DecodePoint(const v1::ContactPoint& point) {
  return {.position = DecodeVector(point.position()),
          .normal = DecodeVector(point.normal()),
          .depth = point.depth(),
          .normal_impulse = point.normal_impulse(),
          .friction_impulse = DecodeVector(point.friction_impulse()),
          .relative_velocity = DecodeVector(point.relative_velocity()),
          .friction = point.friction(),
          .restitution = point.restitution(),
          .geometry_a = point.geometry_a(),
          .geometry_b = point.geometry_b()};
}

Result<Event> DecodeEvent(const v1::Event& event) {
  Result<EventKind> kind = DecodeKind(event);
  if (!kind.ok()) return kind.status();
  return Event{event.sequence(), event.step(), *std::move(kind)};
}

}  // namespace genphys

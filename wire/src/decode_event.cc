#include <memory>
#include <string>
#include <utility>

#include "genphys/wire/decode.h"
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

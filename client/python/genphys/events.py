"""What happens in a world, as immutable values.

Each has the `step` after which it was true and a `sequence`, dense per world and epoch. `Gap` and `EpochBegan` come
from `World.events` alone and say that the sequence has a hole or begins anew.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

from . import _decode, _encode, fields, joints
from .model import Entity, EntityInfo

EntityOf = Callable[[int], Entity]


@dataclasses.dataclass(frozen=True)
class ContactPoint:
    """One point where two geometries touch, in world coordinates.

    Attributes:
        position: Metres.
        normal: Unit length, from entity_a towards entity_b.
        depth: Overlap along the normal, metres; negative when apart.
        normal_impulse: N*s, over the step.
        friction_impulse: On b, N*s, over the step.
        relative_velocity: Of b against a at the point, before the step, m/s.
        friction: Coefficient at rest, as mixed from both materials.
        restitution: As mixed from both materials.
        geometry_a: Id of the geometry of entity_a.
        geometry_b: Id of the geometry of entity_b.
    """

    position: tuple[float, float, float]
    normal: tuple[float, float, float]
    depth: float
    normal_impulse: float
    friction_impulse: tuple[float, float, float]
    relative_velocity: tuple[float, float, float]
    friction: float
    restitution: float
    geometry_a: int
    geometry_b: int


@dataclasses.dataclass(frozen=True)
class Event:
    """The base of all events; itself only for a kind that this version does not know."""

    step: int
    sequence: int

    @property
    def entities(self) -> tuple[Entity, ...]:
        """The entities that it names."""
        names = (field.name for field in dataclasses.fields(self) if field.name != "info")
        values = (getattr(self, name) for name in names)
        return tuple(value for value in values if isinstance(value, Entity))

    def involves(self, entity: object) -> bool:
        """Returns whether it names this `Entity` or id."""
        number = _encode.entity_id(entity, "")
        return any(each.id == number for each in self.entities)


@dataclasses.dataclass(frozen=True)
class ContactBegan(Event):
    """Two entities began to touch; entity_a has the smaller id.

    Of two that met several times in one substep, `points` has those of each time one after the other, with the impulses
    of that time: a place can be among them more than once.
    """

    entity_a: Entity
    entity_b: Entity
    points: tuple[ContactPoint, ...]


@dataclasses.dataclass(frozen=True)
class ContactPersisted(Event):
    """Two entities still touch, of which one at least is awake."""

    entity_a: Entity
    entity_b: Entity
    points: tuple[ContactPoint, ...]


@dataclasses.dataclass(frozen=True)
class ContactEnded(Event):
    """Two entities no longer touch, or one of them is gone."""

    entity_a: Entity
    entity_b: Entity


@dataclasses.dataclass(frozen=True)
class SensorEntered(Event):
    """Something entered a sensor."""

    sensor: Entity
    visitor: Entity


@dataclasses.dataclass(frozen=True)
class SensorLeft(Event):
    """Something left a sensor, or one of them is gone."""

    sensor: Entity
    visitor: Entity


@dataclasses.dataclass(frozen=True)
class EntitySlept(Event):
    """An entity fell asleep."""

    entity: Entity


@dataclasses.dataclass(frozen=True)
class EntityWoke(Event):
    """An entity woke up."""

    entity: Entity


@dataclasses.dataclass(frozen=True)
class EntityStartedMoving(Event):
    """A dynamic entity rose above the threshold of moving, in rotation or else in translation."""

    entity: Entity
    rotation: bool


@dataclasses.dataclass(frozen=True)
class EntityStoppedMoving(Event):
    """A dynamic entity fell below the threshold of moving, in rotation or else in translation."""

    entity: Entity
    rotation: bool


@dataclasses.dataclass(frozen=True)
class JointBroke(Event):
    """A joint was overloaded and is gone; force in N and torque in N*m are what it held in its last step.

    entity_a and entity_b are its sides; None is the world.
    """

    joint: int
    force: float
    torque: float
    entity_a: Entity | None
    entity_b: Entity | None


@dataclasses.dataclass(frozen=True)
class JointCreated(Event):
    """A joint was made; None is the world, `description` what it is."""

    joint: int
    entity_a: Entity | None
    entity_b: Entity | None
    description: joints.Kind | joints.UnknownKind


@dataclasses.dataclass(frozen=True)
class JointUpdated(Event):
    """The description of a joint changed; `changed` are the paths."""

    joint: int
    entity_a: Entity | None
    entity_b: Entity | None
    description: joints.Kind | joints.UnknownKind
    changed: tuple[str, ...]


@dataclasses.dataclass(frozen=True)
class JointDeleted(Event):
    """A joint was removed, alone or with an entity."""

    joint: int
    entity_a: Entity | None
    entity_b: Entity | None


@dataclasses.dataclass(frozen=True)
class ForceFieldCreated(Event):
    """A force field was made."""

    field: int
    info: fields.ForceFieldInfo


@dataclasses.dataclass(frozen=True)
class ForceFieldUpdated(Event):
    """A force field was replaced, or lost an entity that it acted on."""

    field: int
    info: fields.ForceFieldInfo


@dataclasses.dataclass(frozen=True)
class ForceFieldDeleted(Event):
    """A force field was removed, alone or with the last entity that it acted on."""

    field: int


@dataclasses.dataclass(frozen=True)
class EntityFaulted(Event):
    """Left the bounds of the world; disabled at its last good pose, until it is put elsewhere or told how to move.

    Forces do nothing to it.
    """

    entity: Entity


@dataclasses.dataclass(frozen=True)
class _Described(Event):
    """What brings a whole description, which is read when somebody asks for it: most never do."""

    def __getattr__(self, name: str) -> Any:
        # Asked only for what is not there yet.
        message = self.__dict__.get("_message") if name == "info" else None
        if message is None:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        self.__dict__["info"] = _decode.entity_info(message, self.__dict__["entity"]._home)
        self.__dict__.pop("_message", None)
        return self.__dict__["info"]

    def __getstate__(self) -> dict[str, Any]:
        # Copies, and what is stored, have no message.
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}


@dataclasses.dataclass(frozen=True)
class EntityCreated(_Described):
    """An entity appeared; `info` is as it was then."""

    entity: Entity
    info: EntityInfo


@dataclasses.dataclass(frozen=True)
class EntityUpdated(_Described):
    """The description of an entity changed; `info` is as it was then, `changed` are the paths."""

    entity: Entity
    info: EntityInfo
    changed: tuple[str, ...]


@dataclasses.dataclass(frozen=True)
class EntityDeleted(Event):
    """An entity was removed."""

    entity: Entity


@dataclasses.dataclass(frozen=True)
class Gap:
    """Events that a listener will not get, because it was too slow, or that a result of `World.step` has no room for.

    Both numbers are lost ones.
    """

    first_sequence: int
    last_sequence: int


@dataclasses.dataclass(frozen=True)
class EpochBegan:
    """The world was reset: steps and sequences begin anew."""

    epoch: int


def decode(message: Any, entity_of: EntityOf) -> Event:
    """Returns the event of a message; `entity_of` makes handles of ids."""
    kind = message.WhichOneof("kind")
    decoder = _DECODERS.get(kind)
    if decoder is None:
        return Event(message.step, message.sequence)
    return decoder(message.step, message.sequence, getattr(message, kind), entity_of)


Decoder = Callable[[int, int, Any, EntityOf], Event]


def contact_point(message: Any) -> ContactPoint:
    """Returns a ContactPoint message as a value."""
    return ContactPoint(
        position=_decode.vector(message.position),
        normal=_decode.vector(message.normal),
        depth=message.depth,
        normal_impulse=message.normal_impulse,
        friction_impulse=_decode.vector(message.friction_impulse),
        relative_velocity=_decode.vector(message.relative_velocity),
        friction=message.friction,
        restitution=message.restitution,
        geometry_a=message.geometry_a,
        geometry_b=message.geometry_b,
    )


def _contact(kind: Any) -> Decoder:
    return lambda step, sequence, body, of: kind(
        step, sequence, of(body.entity_a), of(body.entity_b), tuple(contact_point(point) for point in body.points)
    )


def _sensor(kind: Any) -> Decoder:
    return lambda step, sequence, body, of: kind(step, sequence, of(body.sensor_entity), of(body.visitor_entity))


def _single(kind: Any) -> Decoder:
    return lambda step, sequence, body, of: kind(step, sequence, of(body.entity_id))


def _moving(kind: Any) -> Decoder:
    return lambda step, sequence, body, of: kind(step, sequence, of(body.entity_id), body.rotation)


def _described(event: type[Event], message: Any, of: EntityOf, **values: Any) -> Event:
    described = event.__new__(event)
    # Its name of then, which may not be that of now.
    handle = Entity(message.id, message.display_name, of(message.id)._home)
    described.__dict__.update(values, entity=handle, _message=message)
    return described


def _created(step: int, sequence: int, body: Any, of: EntityOf) -> Event:
    return _described(EntityCreated, body.entity, of, step=step, sequence=sequence)


def _updated(step: int, sequence: int, body: Any, of: EntityOf) -> Event:
    changed = tuple(body.changed.paths)
    return _described(EntityUpdated, body.entity, of, step=step, sequence=sequence, changed=changed)


def _side(number: int, of: EntityOf) -> Entity | None:
    return of(number) if number else None


def _joint_broke(step: int, sequence: int, body: Any, of: EntityOf) -> Event:
    sides = (_side(body.entity_a, of), _side(body.entity_b, of))
    return JointBroke(step, sequence, body.joint_id, body.force, body.torque, *sides)


def _joint_created(step: int, sequence: int, body: Any, of: EntityOf) -> Event:
    joint = body.joint
    sides = (_side(joint.entity_a.id, of), _side(joint.entity_b.id, of))
    return JointCreated(step, sequence, joint.id, *sides, joints.decode(joint))


def _joint_updated(step: int, sequence: int, body: Any, of: EntityOf) -> Event:
    joint = body.joint
    sides = (_side(joint.entity_a.id, of), _side(joint.entity_b.id, of))
    return JointUpdated(step, sequence, joint.id, *sides, joints.decode(joint), tuple(body.changed.paths))


def _joint_deleted(step: int, sequence: int, body: Any, of: EntityOf) -> Event:
    return JointDeleted(step, sequence, body.joint_id, _side(body.entity_a, of), _side(body.entity_b, of))


def _field(kind: Any) -> Decoder:
    return lambda step, sequence, body, of: kind(step, sequence, body.field.id, fields.decode(body.field))


_DECODERS: dict[str, Decoder] = {
    "contact_began": _contact(ContactBegan),
    "contact_persisted": _contact(ContactPersisted),
    "contact_ended": lambda step, sequence, body, of: ContactEnded(
        step, sequence, of(body.entity_a), of(body.entity_b)
    ),
    "sensor_entered": _sensor(SensorEntered),
    "sensor_left": _sensor(SensorLeft),
    "entity_slept": _single(EntitySlept),
    "entity_woke": _single(EntityWoke),
    "entity_started_moving": _moving(EntityStartedMoving),
    "entity_stopped_moving": _moving(EntityStoppedMoving),
    "joint_broke": _joint_broke,
    "joint_created": _joint_created,
    "joint_updated": _joint_updated,
    "joint_deleted": _joint_deleted,
    "force_field_created": _field(ForceFieldCreated),
    "force_field_updated": _field(ForceFieldUpdated),
    "force_field_deleted": lambda step, sequence, body, of: ForceFieldDeleted(step, sequence, body.field_id),
    "entity_faulted": _single(EntityFaulted),
    "entity_created": _created,
    "entity_updated": _updated,
    "entity_deleted": _single(EntityDeleted),
}

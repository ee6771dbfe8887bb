"""What happens in a world, as immutable values.

Each has the `step` after which it was true and a `sequence`, dense per world and epoch. `Gap` and `EpochBegan` come
from `World.events` alone and say that the sequence has a hole or begins anew.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

from . import _decode
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
        values = (getattr(self, field.name) for field in dataclasses.fields(self))
        return tuple(value for value in values if isinstance(value, Entity))

    def involves(self, entity: object) -> bool:
        """Returns whether it names this `Entity` or id."""
        number = entity.__index__()  # type: ignore[attr-defined]
        return any(each.id == number for each in self.entities)


@dataclasses.dataclass(frozen=True)
class ContactBegan(Event):
    """Two entities began to touch; entity_a has the smaller id."""

    entity_a: Entity
    entity_b: Entity
    points: tuple[ContactPoint, ...]


@dataclasses.dataclass(frozen=True)
class ContactPersisted(Event):
    """Two entities still touch."""

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
    """Rose above the threshold of moving, in rotation or else in translation."""

    entity: Entity
    rotation: bool


@dataclasses.dataclass(frozen=True)
class EntityStoppedMoving(Event):
    """Fell below the threshold of moving, in rotation or else in translation."""

    entity: Entity
    rotation: bool


@dataclasses.dataclass(frozen=True)
class JointBroke(Event):
    """A joint was overloaded and is gone; force in N and torque in N*m are what it held in its last step."""

    joint: int
    force: float
    torque: float


@dataclasses.dataclass(frozen=True)
class EntityFaulted(Event):
    """Left the bounds of the world; disabled at its last good pose."""

    entity: Entity


@dataclasses.dataclass(frozen=True)
class EntityCreated(Event):
    """An entity appeared; `info` is as it was then."""

    entity: Entity
    info: EntityInfo


@dataclasses.dataclass(frozen=True)
class EntityUpdated(Event):
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
    """Events that this listener will not get, because it was too slow; both numbers are lost ones."""

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


def _created(step: int, sequence: int, body: Any, of: EntityOf) -> Event:
    info = _decode.entity_info(body.entity)
    return EntityCreated(step, sequence, info.entity, info)


def _updated(step: int, sequence: int, body: Any, of: EntityOf) -> Event:
    info = _decode.entity_info(body.entity)
    return EntityUpdated(step, sequence, info.entity, info, tuple(body.changed.paths))


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
    "joint_broke": lambda step, sequence, body, of: JointBroke(step, sequence, body.joint_id, body.force, body.torque),
    "entity_faulted": _single(EntityFaulted),
    "entity_created": _created,
    "entity_updated": _updated,
    "entity_deleted": _single(EntityDeleted),
}

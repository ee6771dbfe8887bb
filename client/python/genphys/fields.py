"""Force fields: what acts on until it is removed, computed anew at every step. SI units, world coordinates."""

from __future__ import annotations

import dataclasses
import reprlib
from collections.abc import Callable, Sequence
from typing import Any, Union

import numpy as np

from . import _arguments, _encode
from ._arguments import Handle, handle_id, instance, items
from ._contract import make
from .model import Vector

_ZERO = (0.0, 0.0, 0.0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Uniform:
    """The same push everywhere: `force` in N on each entity, `acceleration` in m/s^2 on top of gravity."""

    force: Vector = _ZERO
    acceleration: Vector = _ZERO


@dataclasses.dataclass(frozen=True, kw_only=True)
class Drag:
    """Resistance of a medium, F = -(linear + quadratic |v|) v and T = -angular w; of one that moves: wind.

    Attributes:
        linear: N*s/m.
        quadratic: N*s^2/m^2.
        angular: N*m*s.
        medium_velocity: m/s.
    """

    linear: float = 0.0
    quadratic: float = 0.0
    angular: float = 0.0
    medium_velocity: Vector = _ZERO


@dataclasses.dataclass(frozen=True, kw_only=True)
class Spring:
    """A spring with a damper between points of two entities, or of one and the world.

    Attributes:
        a: An entity or its id.
        b: Another one; None is the world.
        point_in_a: Metres, in the frame of a.
        point_in_b: Metres, in the frame of b or of the world.
        rest_length: Metres.
        stiffness: N/m.
        damping: N*s/m.
    """

    a: Any
    b: Any = None
    point_in_a: Vector = _ZERO
    point_in_b: Vector = _ZERO
    rest_length: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class PointGravity:
    """Pulls towards `center` with m strength r / (r^2 + softening^2)^(3/2); strength is G M in m^3/s^2."""

    strength: float
    center: Vector = _ZERO
    softening: float | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Buoyancy:
    """A fluid below a surface.

    Attributes:
        surface_normal: Unit length, out of the fluid; None is up.
        surface_offset: The surface is where dot(normal, p) is this, metres.
        fluid_density: kg/m^3; None is 1000.
        drag: Of an entity that is all below the surface.
    """

    surface_normal: Vector | None = None
    surface_offset: float = 0.0
    fluid_density: float | None = None
    drag: Drag | None = None


Field = Union[Uniform, Drag, Spring, PointGravity, Buoyancy]


class ForceField(Handle):
    """Names a force field of a world; its id is known once the server made it.

    Handles compare and hash by id. Those of two worlds may be equal by chance.
    """

    def __init__(self, number: int | None = None, home: str = "") -> None:
        super().__init__(home)
        self._id = number

    @property
    def id(self) -> int:
        """Raises ValueError as long as the batch that makes it was not taken along, and if that was refused."""
        return _arguments.id_in_batch(self, "a new force field")

    def __index__(self) -> int:
        return self.id

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ForceField):
            return NotImplemented
        return self is other or (self._id is not None and self._id == other._id)

    def __hash__(self) -> int:
        return hash(self.id)

    def __repr__(self) -> str:
        return f"ForceField({self._id})"


@dataclasses.dataclass(frozen=True, kw_only=True)
class ForceFieldInfo(Handle):
    """One force field as it was when asked for. Accepted wherever a `ForceField` is.

    Attributes:
        force_field: Its handle.
        field: What it does; None for a kind of a newer server. A spring names its entities by id, 0 is the world.
        entities: Ids of those on which it acts; empty: all dynamic ones.
        region: Two opposite corners, metres; None is everywhere.
    """

    force_field: ForceField
    field: Field | None
    entities: tuple[int, ...]
    region: tuple[tuple[float, float, float], tuple[float, float, float]] | None

    @property
    def id(self) -> int:
        """The id of the force field."""
        return self.force_field.id

    @property
    def _home(self) -> str:
        return self.force_field._home

    def __index__(self) -> int:
        return self.id


def field_id(field: Any, home: str) -> int:
    """Returns the id of a ForceField, a ForceFieldInfo or a number; raises TypeError for any other handle."""
    return handle_id(field, (ForceField, ForceFieldInfo), "a ForceField", home)


def _drag(field: Drag) -> Any:
    instance(field, Drag, "drag", "fields.Drag")
    return make.DragField(
        linear=field.linear,
        quadratic=field.quadratic,
        angular=field.angular,
        medium_velocity=_encode.vector(field.medium_velocity, "medium_velocity"),
    )


def _uniform(field: Uniform, home: str) -> dict[str, Any]:
    return {
        "uniform": make.UniformField(
            force=_encode.vector(field.force, "force"), acceleration=_encode.vector(field.acceleration, "acceleration")
        )
    }


def _spring(field: Spring, home: str) -> dict[str, Any]:
    return {
        "spring": make.SpringField(
            entity_a=_encode.entity_id(field.a, home),
            entity_b=0 if field.b is None else _encode.entity_id(field.b, home),
            point_in_a=_encode.vector(field.point_in_a, "point_in_a"),
            point_in_b=_encode.vector(field.point_in_b, "point_in_b"),
            rest_length=field.rest_length,
            stiffness=field.stiffness,
            damping=field.damping,
        )
    }


def _point_gravity(field: PointGravity, home: str) -> dict[str, Any]:
    return {
        "point_gravity": make.PointGravityField(
            center=_encode.vector(field.center, "center"), strength=field.strength, softening=field.softening
        )
    }


def _buoyancy(field: Buoyancy, home: str) -> dict[str, Any]:
    normal = field.surface_normal
    return {
        "buoyancy": make.BuoyancyField(
            surface_normal=None if normal is None else _encode.vector(normal, "surface_normal"),
            surface_offset=field.surface_offset,
            fluid_density=field.fluid_density,
            drag=None if field.drag is None else _drag(field.drag),
        )
    }


_KINDS = {
    Uniform: _uniform,
    Drag: lambda field, home: {"drag": _drag(field)},
    Spring: _spring,
    PointGravity: _point_gravity,
    Buoyancy: _buoyancy,
}


def message(
    home: str,
    field: Field,
    entities: Sequence[Any] = (),
    region: tuple[Vector, Vector] | None = None,
    number: int = 0,
) -> Any:
    """Returns a ForceField message; raises TypeError for what is no field."""
    if type(field) not in _KINDS:
        kinds = ", ".join(f"genphys.fields.{each.__name__}(...)" for each in _KINDS)
        raise TypeError(f"field is {reprlib.repr(field)}, not one of: {kinds}")
    if type(field) is Spring:
        for name, told in (("entities", len(entities) > 0), ("region", region is not None)):
            if told:
                raise ValueError(f"{name} has no effect here: a spring acts on its a and b, wherever they are")
    bounds = None
    if region is not None:
        if not isinstance(region, (tuple, list, np.ndarray)) or len(region) != 2:
            raise ValueError(f"region is {region!r}, not two opposite corners")
        corner, opposite = region
        bounds = make.Region(
            corner=_encode.vector(corner, "region"), opposite_corner=_encode.vector(opposite, "region")
        )
    return make.ForceField(
        id=number,
        entity_ids=_encode.entity_ids(entities, "entities", home),
        region=bounds,
        **_KINDS[type(field)](field, home),
    )


def creation(
    home: str,
    field: Field,
    entities: Sequence[Any],
    region: tuple[Vector, Vector] | None,
    made_by: Callable[[Any], int | None],
) -> Any:
    """Returns a CreateForceField command; `made_by` gives the place of the command that makes an entity, or None."""
    entities = list(items(entities, "entities"))
    there = [each for each in entities if made_by(each) is None]
    ends: dict[str, int] = {}
    if isinstance(field, Spring):
        for name in ("a", "b"):
            place = made_by(getattr(field, name))
            if place is not None:
                ends[f"spring_{name}_created_by_command"] = place
                field = dataclasses.replace(field, **{name: 0})
    return make.CreateForceField(
        field=message(home, field, there if type(field) is not Spring else entities, region),
        created_by_commands=[place for place in map(made_by, entities) if place is not None],
        **ends,
    )


def shift(command: Any, offset: int) -> None:
    """Moves the places that a CreateForceField command names."""
    places = [place + offset for place in command.created_by_commands]
    command.created_by_commands[:] = places
    for name in ("spring_a_created_by_command", "spring_b_created_by_command"):
        if command.HasField(name):
            setattr(command, name, getattr(command, name) + offset)


def _vector(message: Any) -> tuple[float, float, float]:
    return (message.x, message.y, message.z)


def _decode_drag(message: Any) -> Drag:
    return Drag(
        linear=message.linear,
        quadratic=message.quadratic,
        angular=message.angular,
        medium_velocity=_vector(message.medium_velocity),
    )


_DECODERS: dict[str, Any] = {
    "uniform": lambda m: Uniform(force=_vector(m.force), acceleration=_vector(m.acceleration)),
    "drag": _decode_drag,
    "spring": lambda m: Spring(
        a=m.entity_a,
        b=m.entity_b or None,
        point_in_a=_vector(m.point_in_a),
        point_in_b=_vector(m.point_in_b),
        rest_length=m.rest_length,
        stiffness=m.stiffness,
        damping=m.damping,
    ),
    "point_gravity": lambda m: PointGravity(
        strength=m.strength, center=_vector(m.center), softening=m.softening if m.HasField("softening") else None
    ),
    "buoyancy": lambda m: Buoyancy(
        surface_normal=_vector(m.surface_normal) if m.HasField("surface_normal") else None,
        surface_offset=m.surface_offset,
        fluid_density=m.fluid_density if m.HasField("fluid_density") else None,
        drag=_decode_drag(m.drag) if m.HasField("drag") else None,
    ),
}


def decode(message: Any, home: str = "") -> ForceFieldInfo:
    """Returns the description of a ForceField message."""
    kind = message.WhichOneof("kind")
    region = message.region
    return ForceFieldInfo(
        force_field=ForceField(message.id, home),
        field=_DECODERS[kind](getattr(message, kind)) if kind in _DECODERS else None,
        entities=tuple(message.entity_ids),
        region=(_vector(region.corner), _vector(region.opposite_corner)) if message.HasField("region") else None,
    )

"""Force fields: what acts on until it is removed, computed anew at every step. SI units, world coordinates."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any, Union

from . import _encode
from ._contract import wire
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


class ForceField:
    """Names a force field of a world; its id is known once the server made it."""

    def __init__(self, number: int | None = None) -> None:
        self._id = number

    @property
    def id(self) -> int:
        """Raises ValueError as long as the batch that makes it was not taken along."""
        if self._id is None:
            raise ValueError("this force field is made by a batch that was not taken along yet")
        return self._id

    def __index__(self) -> int:
        return self.id

    def __repr__(self) -> str:
        return f"ForceField({self._id})"


def _drag(field: Drag) -> Any:
    return wire.DragField(
        linear=field.linear,
        quadratic=field.quadratic,
        angular=field.angular,
        medium_velocity=_encode.vector(field.medium_velocity, "medium_velocity"),
    )


def _uniform(field: Uniform) -> dict[str, Any]:
    return {
        "uniform": wire.UniformField(
            force=_encode.vector(field.force, "force"), acceleration=_encode.vector(field.acceleration, "acceleration")
        )
    }


def _spring(field: Spring) -> dict[str, Any]:
    return {
        "spring": wire.SpringField(
            entity_a=_encode.entity_id(field.a),
            entity_b=0 if field.b is None else _encode.entity_id(field.b),
            point_in_a=_encode.vector(field.point_in_a, "point_in_a"),
            point_in_b=_encode.vector(field.point_in_b, "point_in_b"),
            rest_length=field.rest_length,
            stiffness=field.stiffness,
            damping=field.damping,
        )
    }


def _point_gravity(field: PointGravity) -> dict[str, Any]:
    return {
        "point_gravity": wire.PointGravityField(
            center=_encode.vector(field.center, "center"), strength=field.strength, softening=field.softening
        )
    }


def _buoyancy(field: Buoyancy) -> dict[str, Any]:
    normal = field.surface_normal
    return {
        "buoyancy": wire.BuoyancyField(
            surface_normal=None if normal is None else _encode.vector(normal, "surface_normal"),
            surface_offset=field.surface_offset,
            fluid_density=field.fluid_density,
            drag=None if field.drag is None else _drag(field.drag),
        )
    }


_KINDS = {
    Uniform: _uniform,
    Drag: lambda field: {"drag": _drag(field)},
    Spring: _spring,
    PointGravity: _point_gravity,
    Buoyancy: _buoyancy,
}


def message(
    field: Field, entities: Sequence[Any] = (), region: tuple[Vector, Vector] | None = None, number: int = 0
) -> Any:
    """Returns a ForceField message; raises TypeError for what is no field."""
    if type(field) not in _KINDS:
        raise TypeError(f"{field!r} is not a force field: Uniform, Drag, Spring, PointGravity or Buoyancy")
    bounds = None
    if region is not None:
        corner, opposite = region
        bounds = wire.Region(
            corner=_encode.vector(corner, "region"), opposite_corner=_encode.vector(opposite, "region")
        )
    return wire.ForceField(
        id=number,
        entity_ids=[_encode.entity_id(each) for each in entities],
        region=bounds,
        **_KINDS[type(field)](field),
    )

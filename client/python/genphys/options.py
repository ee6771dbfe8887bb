"""The keywords that make an entity: what they are for type checkers, and what they mean for all."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any, TypedDict, TypeVar

from . import model
from .model import Quaternion, Vector

AnyCallable = TypeVar("AnyCallable", bound=Callable[..., Any])


class BodyOptions(TypedDict, total=False):
    """Keywords of every `add_...`. What is left out has the default of the world.

    Attributes:
        name: For people.
        position: Of its frame in the world, metres.
        orientation: Of its frame in the world: (w, x, y, z), of unit length.
        linear_velocity: Of the centre of mass, m/s.
        angular_velocity: rad/s, world coordinates.
        motion: "dynamic", "kinematic" or "static".
        mass: kg. This and what follows, up to locked_axes, counts while it is dynamic, as it may become.
        linear_damping: 1/s: its velocity decays as exp(-c t).
        angular_damping: The same of its spin, 1/s.
        gravity_scale: Part of the world's gravity that acts on it.
        linear_speed_max: m/s: what would be faster is slowed down to it.
        angular_speed_max: rad/s, likewise.
        auto_disable: When it falls asleep: `genphys.AutoDisable`.
        locked_axes: Axes of the world along and about which it does not move: `genphys.LockedAxes`.
        error_correction: How its overlaps and the gaps of its joints are taken away: `genphys.ErrorCorrection`.
        ignored_entities: Those that it and they never touch, whatever the filters say.
        visual: What to draw: `genphys.Visual`.
    """

    name: str
    position: Vector
    orientation: Quaternion
    linear_velocity: Vector
    angular_velocity: Vector
    motion: str
    mass: float
    linear_damping: float
    angular_damping: float
    gravity_scale: float
    linear_speed_max: float
    angular_speed_max: float
    auto_disable: model.AutoDisable
    locked_axes: model.LockedAxes
    error_correction: model.ErrorCorrection
    ignored_entities: Sequence[model.Entity | model.EntityInfo | int]
    visual: model.Visual


class InertiaOptions(TypedDict, total=False):
    """Keywords of a body whose mass is not spread evenly.

    Attributes:
        center_of_mass: In the entity's frame, metres.
        inertia_tensor: About it, kg*m^2, 3 x 3 or xx xy xz yy yz zz.
    """

    center_of_mass: Vector
    inertia_tensor: Any


class ShapeOptions(BodyOptions, InertiaOptions, total=False):
    """Keywords of `add_sphere` and its like: those of every entity, and those of its one `genphys.Geometry`.

    Attributes:
        density: kg/m^3, instead of mass.
        friction: Coulomb coefficient at rest, 0 to 1000.
        kinetic_friction: Coulomb coefficient while sliding.
        restitution: Speed of separation over speed of approach, 0 to 1.
        friction_mixing: How friction of two sides becomes one: "geometric_mean", "average", "minimum", "multiply" or
            "maximum".
        restitution_mixing: The same for restitution.
        rolling_friction: Largest torque against rolling over the normal force, metres.
        spinning_friction: The same against spinning about the normal.
        sensor: Reports overlaps and pushes nothing.
        collision_space: Members of one space never collide with each other; "car/wheels" is inside "car".
        category_bits: The categories that it belongs to, one bit each.
        collides_with_bits: The categories that it collides with; both of a pair must agree.
        surface_velocity: How its surface runs over it, m/s, in its own frame: a conveyor belt.
    """

    density: float
    friction: float
    kinetic_friction: float
    restitution: float
    friction_mixing: str
    restitution_mixing: str
    rolling_friction: float
    spinning_friction: float
    sensor: bool
    collision_space: str
    category_bits: int
    collides_with_bits: int
    surface_velocity: Vector


class EntityOptions(BodyOptions, InertiaOptions, total=False):
    """Keywords of `add_entity` beside geometries and physics: those of every entity, and of how its mass is spread."""


_PARTS: dict[Any, tuple[Any, ...]] = {
    ShapeOptions: (BodyOptions, InertiaOptions, ShapeOptions),
    EntityOptions: (BodyOptions, InertiaOptions),
}


def explained(options: Any) -> Callable[[AnyCallable], AnyCallable]:
    """Lets `help` of a method tell its keywords, of which Python knows no more than that there are some."""
    lines: list[str] = []
    for part in _PARTS[options]:
        lines += inspect.cleandoc(part.__doc__ or "").partition("Attributes:\n")[2].splitlines()

    def explain(method: AnyCallable) -> AnyCallable:
        if not lines:  # without docstrings (-OO) there is nothing to tell
            return method
        method.__doc__ = "\n".join([inspect.cleandoc(method.__doc__ or ""), "", "Keywords:", *lines])
        return method

    return explain

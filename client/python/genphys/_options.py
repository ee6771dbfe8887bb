"""The keywords that make an entity, for type checkers and editors alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypedDict

from . import model
from .model import Quaternion, Vector


class BodyOptions(TypedDict, total=False):
    """Keywords of every `add_...`.

    name: for people. position: metres, world. orientation: (w, x, y, z). linear_velocity: of the centre of mass,
    m/s. angular_velocity: rad/s. motion: "dynamic", "kinematic" or "static". mass: kg. linear_damping and
    angular_damping: 1/s, the velocity decays as exp(-c t). gravity_scale: part of the world's gravity that
    acts on it. linear_speed_max (m/s) and angular_speed_max (rad/s): what would be faster is slowed down to it.
    locked_axes: axes of the world along and about which it does not move. ignored_entities: those that it and they
    never touch, whatever the filters say.
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
    locked_axes: model.LockedAxes
    auto_disable: model.AutoDisable
    error_correction: model.ErrorCorrection
    ignored_entities: Sequence[model.Entity | model.EntityInfo | int]
    visual: model.Visual


class ShapeOptions(BodyOptions, total=False):
    """Keywords of `add_sphere` and its like: those of every entity, and those of its one geometry.

    density: kg/m^3, instead of mass. The others are explained at `Geometry`.
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


class EntityOptions(BodyOptions, total=False):
    """Keywords of `add_entity` beside those of every entity.

    center_of_mass: in the entity's frame, metres. inertia_tensor: about it, kg*m^2, 3 x 3 or xx xy xz yy yz zz.
    """

    center_of_mass: Vector
    inertia_tensor: Any

"""Messages -> the values of `model`."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from . import joints, model
from ._contract import FEATURE, MIXING, MOTION, WORLD_STATE
from .frame import stamp_of

_DEFAULT_MOTION = "dynamic"


def vector(message: Any) -> tuple[float, float, float]:
    """Returns x, y, z."""
    return (message.x, message.y, message.z)


def orientation(pose: Any) -> tuple[float, float, float, float]:
    """Returns w, x, y, z of a Pose; the identity when unset."""
    if not pose.HasField("orientation"):
        return (1.0, 0.0, 0.0, 0.0)
    q = pose.orientation
    return (q.w, q.x, q.y, q.z)


def entity_info(message: Any, home: str = "") -> model.EntityInfo:
    """Returns the description of an Entity message."""
    body = message.rigid_body
    return model.EntityInfo(
        entity=model.Entity(message.id, message.display_name, home),
        name=message.display_name,
        position=vector(message.pose.position),
        orientation=orientation(message.pose),
        physics=message.HasField("rigid_body"),
        motion=MOTION.word(body.motion_type) if body.motion_type else _DEFAULT_MOTION,
        linear_velocity=vector(body.linear_velocity),
        angular_velocity=vector(body.angular_velocity),
        mass=_optional(body.inertia, "mass"),
        geometries=tuple(_geometry(each) for each in body.geometries),
        visual=_visual(message),
        locked_axes=model.LockedAxes(
            **{field.name: getattr(body.locked_axes, field.name) for field in dataclasses.fields(model.LockedAxes)}
        ),
        error_correction=model.ErrorCorrection(
            time_constant=_optional(body.error_correction, "time_constant_seconds"),
            correction_speed_max=_optional(body.error_correction, "correction_speed_max"),
            slop=_optional(body.error_correction, "slop_metres"),
        ),
        ignored_entities=tuple(body.ignored_entity_ids),
    )


def joint_info(message: Any, state: Any, home: str) -> joints.JointInfo:
    """Returns the description of a Joint message with its JointState."""
    return joints.JointInfo(
        joint=joints.Joint(message.id, home),
        entity_a=message.entity_a.id,
        entity_b=message.entity_b.id,
        kind=joints.decode(message),
        frame_in_a=(vector(message.frame_in_a.position), orientation(message.frame_in_a)),
        frame_in_b=(vector(message.frame_in_b.position), orientation(message.frame_in_b)),
        collide_connected=message.collide_connected,
        break_force=_optional(message, "break_force"),
        break_torque=_optional(message, "break_torque"),
        positions=tuple(state.positions),
        rates=tuple(state.rates),
        force=vector(state.force),
        torque=vector(state.torque),
    )


def engine_info(message: Any) -> model.EngineInfo:
    """Returns the description of an Engine message."""
    return model.EngineInfo(
        name=short_name(message.name),
        version=message.version,
        features=frozenset(FEATURE.word(each) for each in message.features),
    )


def world_info(world: Any, stamp: Any) -> model.WorldInfo:
    """Returns the description of a World message."""
    return model.WorldInfo(
        name=short_name(world.name),
        engine=short_name(world.engine),
        state=WORLD_STATE.word(world.state),
        gravity=vector(world.gravity),
        step_size=world.stepper.step_size_seconds,
        stamp=stamp_of(stamp),
        recorded_events=model.EventKinds(
            **{each.name: getattr(world.recorded_events, each.name) for each in dataclasses.fields(model.EventKinds)}
        ),
    )


def short_name(resource: str) -> str:
    """Returns "lab" of "worlds/lab"."""
    return resource.rpartition("/")[2]


def _optional(message: Any, field: str) -> Any:
    return getattr(message, field) if message.HasField(field) else None


def _visual(message: Any) -> model.Visual | None:
    if not message.HasField("visual"):
        return None
    visual = message.visual
    return model.Visual(uri=visual.uri, media_type=visual.media_type, data=visual.data)


def _geometry(message: Any) -> model.Geometry:
    return model.Geometry(
        shape=_shape(message.shape),
        position=vector(message.pose_in_entity.position),
        orientation=orientation(message.pose_in_entity),
        friction=_optional(message.material, "friction"),
        kinetic_friction=_optional(message.material, "kinetic_friction"),
        restitution=_optional(message.material, "restitution"),
        density=_optional(message.material, "density"),
        friction_mixing=MIXING.word(message.material.friction_mixing),
        restitution_mixing=MIXING.word(message.material.restitution_mixing),
        rolling_friction=_optional(message.material, "rolling_friction"),
        spinning_friction=_optional(message.material, "spinning_friction"),
        sensor=message.is_sensor,
        collision_space=message.collision_space,
        category_bits=_optional(message, "category_bits"),
        collides_with_bits=_optional(message, "collides_with_bits"),
        surface_velocity=vector(message.surface_velocity),
        id=message.id,
    )


def _shape(message: Any) -> model.Shape | model.UnknownShape:
    kind = message.WhichOneof("kind")
    if kind is None or kind not in _SHAPES:
        return model.UnknownShape(kind or "")
    return _SHAPES[kind](getattr(message, kind))


_SHAPES: dict[str, Callable[[Any], model.Shape]] = {
    "sphere": lambda sphere: model.Sphere(sphere.radius),
    "box": lambda box: model.Box(vector(box.half_extents)),
    "capsule": lambda capsule: model.Capsule(capsule.radius, capsule.half_length),
    "cylinder": lambda cylinder: model.Cylinder(cylinder.radius, cylinder.half_length),
    "plane": lambda plane: model.Plane(
        vector(plane.normal) if plane.HasField("normal") else (0.0, 0.0, 1.0), plane.offset
    ),
    "cone": lambda cone: model.Cone(cone.radius, cone.half_length),
    "ellipsoid": lambda ellipsoid: model.Ellipsoid(vector(ellipsoid.semi_axes)),
    "convex_hull": lambda hull: model.ConvexHull(np.reshape(hull.vertices, (-1, 3))),
    "triangle_mesh": lambda mesh: model.TriangleMesh(
        np.reshape(mesh.vertices, (-1, 3)), np.array(mesh.indices, np.uint32).reshape(-1, 3)
    ),
    "heightfield": lambda field: model.Heightfield(
        np.reshape(field.heights, (field.rows, field.columns)), field.cell_size
    ),
}

"""Python values -> messages. Shapes of arguments are checked here, their values by the server."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from . import model
from ._contract import COORDINATES, FEATURE, MIXING, MOTION, QUALITY, SCALAR, SOLVER, wire


def vector(value: Any, what: str) -> Any:
    """Returns a Vector3; raises ValueError unless `value` has three numbers."""
    x, y, z = _numbers(value, 3, what)
    return wire.Vector3(x=x, y=y, z=z)


def quaternion(value: Any, what: str) -> Any:
    """Returns a Quaternion; raises ValueError unless `value` has four numbers."""
    w, x, y, z = _numbers(value, 4, what)
    return wire.Quaternion(w=w, x=x, y=y, z=z)


def pose(position: Any, orientation: Any) -> Any:
    """Returns a Pose; None leaves a part at its default."""
    return wire.Pose(
        position=None if position is None else vector(position, "position"),
        orientation=None if orientation is None else quaternion(orientation, "orientation"),
    )


def entity_id(entity: Any) -> int:
    """Returns the id of an Entity, an EntityInfo or a number."""
    try:
        return operator.index(entity)
    except TypeError:
        raise TypeError(f"expected an Entity or its id, not {type(entity).__name__}") from None


def frame(value: Any, what: str) -> Any:
    """Returns the Pose of a joint frame: a position, or a pair of position and orientation; None stays None."""
    if value is None:
        return None
    if len(value) == 2:
        return wire.Pose(position=vector(value[0], what), orientation=quaternion(value[1], what))
    return wire.Pose(position=vector(value, what))


def number_column(values: Any, what: str) -> bytes:
    """Returns an array of shape (n,) as a byte column; raises ValueError if it has another shape."""
    array = np.ascontiguousarray(values, "<f8")
    if array.ndim != 1:
        raise ValueError(f"{what} has shape {array.shape}, not (n,)")
    return array.tobytes()


def id_column(entities: Any) -> bytes:
    """Returns ids as a byte column; an array of numbers takes the fast way."""
    if isinstance(entities, np.ndarray) and entities.dtype.kind in "iu":
        return np.ascontiguousarray(entities, "<u8").tobytes()
    return np.fromiter((entity_id(each) for each in entities), "<u8").tobytes()


def vector_column(values: Any, what: str) -> bytes:
    """Returns an array of shape (n, 3) as a byte column; raises ValueError if it has another shape."""
    array = np.ascontiguousarray(values, "<f8")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{what} has shape {array.shape}, not (n, 3)")
    return array.tobytes()


def quaternion_column(values: Any, what: str) -> bytes:
    """Returns an array of shape (n, 4) as a byte column; raises ValueError if it has another shape."""
    array = np.ascontiguousarray(values, "<f8")
    if array.ndim != 2 or array.shape[1] != 4:
        raise ValueError(f"{what} has shape {array.shape}, not (n, 4)")
    return array.tobytes()


def frame_request(frame: bool | model.FrameRequest | None) -> Any:
    """Returns a FrameRequest message; None when no frame is wanted."""
    if frame is None or frame is False:
        return None
    wanted = model.FrameRequest() if frame is True else frame
    return wire.FrameRequest(
        scalar=SCALAR.number(wanted.dtype),
        poses=wanted.poses,
        velocities=wanted.velocities,
        net_forces=wanted.net_forces,
        entity_ids=[entity_id(each) for each in wanted.entities],
        deltas=wanted.deltas,
        joints=wanted.joints,
    )


def event_kinds(kinds: model.EventKinds) -> Any:
    """Returns an EventKinds message."""
    return wire.EventKinds(**vars(kinds))


def event_filter(events: bool | model.EventFilter | None) -> Any:
    """Returns an EventFilter message; None when no events are wanted."""
    if events is None or events is False:
        return None
    if events is True:
        return wire.EventFilter()
    return wire.EventFilter(
        kinds=None if events.kinds is None else event_kinds(events.kinds),
        entity_ids=[entity_id(each) for each in events.entities],
    )


def stepper(
    step_size: float | None,
    quality: str | None,
    solver: str | None,
    substeps: int | None,
    iterations: int | None,
    engine_only: bool,
) -> Any:
    """Returns a Stepper message; None leaves a value at its default."""
    return wire.Stepper(
        step_size_seconds=step_size,
        quality=None if quality is None else QUALITY.number(quality),
        solver=None if solver is None else SOLVER.number(solver),
        substeps=substeps,
        iterations=iterations,
        engine_only=engine_only,
    )


def coordinates(word: str) -> int:
    """Returns the number of "world" or "entity"."""
    return COORDINATES.number(word)


def features(words: Iterable[str]) -> list[int]:
    """Returns the numbers of features named as in "shape_box"."""
    return [FEATURE.number(word) for word in words]


def material(
    *,
    friction: float | None = None,
    kinetic_friction: float | None = None,
    restitution: float | None = None,
    density: float | None = None,
    friction_mixing: str | None = None,
    restitution_mixing: str | None = None,
    rolling_friction: float | None = None,
    spinning_friction: float | None = None,
) -> Any:
    """Returns a Material message, or None if nothing is said."""
    numbers = (friction, kinetic_friction, restitution, density, rolling_friction, spinning_friction)
    if all(value is None for value in (*numbers, friction_mixing, restitution_mixing)):
        return None
    return wire.Material(
        friction=friction,
        kinetic_friction=kinetic_friction,
        restitution=restitution,
        density=density,
        friction_mixing=None if friction_mixing is None else MIXING.number(friction_mixing),
        restitution_mixing=None if restitution_mixing is None else MIXING.number(restitution_mixing),
        rolling_friction=rolling_friction,
        spinning_friction=spinning_friction,
    )


def sleep_policy(policy: model.AutoDisable | None) -> Any:
    """Returns an AutoDisable message, or None."""
    if policy is None:
        return None
    return wire.AutoDisable(
        enabled=policy.enabled,
        linear_speed_max=policy.linear_speed_max,
        angular_speed_max=policy.angular_speed_max,
        rest_time_seconds=policy.rest_time,
    )


def correction_policy(policy: model.ErrorCorrection | None) -> Any:
    """Returns an ErrorCorrection message, or None."""
    if policy is None:
        return None
    return wire.ErrorCorrection(
        time_constant_seconds=policy.time_constant,
        slop_metres=policy.slop,
        correction_speed_max=policy.correction_speed_max,
    )


def shape(value: Any) -> Any:
    """Returns a Shape message; raises TypeError for what is no shape."""
    if isinstance(value, model.Sphere):
        return wire.Shape(sphere=wire.Sphere(radius=value.radius))
    if isinstance(value, model.Box):
        return wire.Shape(box=wire.Box(half_extents=vector(value.half_extents, "half_extents")))
    if isinstance(value, model.Capsule):
        return wire.Shape(capsule=wire.Capsule(radius=value.radius, half_length=value.half_length))
    if isinstance(value, model.Cylinder):
        return wire.Shape(cylinder=wire.Cylinder(radius=value.radius, half_length=value.half_length))
    if isinstance(value, model.Plane):
        return wire.Shape(plane=wire.Plane(normal=vector(value.normal, "normal"), offset=value.offset))
    if isinstance(value, model.Cone):
        return wire.Shape(cone=wire.Cone(radius=value.radius, half_length=value.half_length))
    if isinstance(value, model.Ellipsoid):
        return wire.Shape(ellipsoid=wire.Ellipsoid(semi_axes=vector(value.semi_axes, "semi_axes")))
    if isinstance(value, model.ConvexHull):
        return wire.Shape(convex_hull=wire.ConvexHull(vertices=_rows(value.vertices, "vertices")))
    if isinstance(value, model.TriangleMesh):
        indices = np.asarray(value.indices)
        if indices.ndim != 2 or indices.shape[1] != 3:
            raise ValueError(f"indices has shape {indices.shape}, not (n, 3)")
        mesh = wire.TriangleMesh(vertices=_rows(value.vertices, "vertices"), indices=indices.ravel().tolist())
        return wire.Shape(triangle_mesh=mesh)
    if isinstance(value, model.Heightfield):
        return wire.Shape(heightfield=_heightfield(value))
    raise TypeError(f"{value!r} is not a shape")


def _rows(values: Any, what: str) -> list[float]:
    array = np.asarray(values, np.float64)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{what} has shape {array.shape}, not (n, 3)")
    return array.ravel().tolist()


def _heightfield(value: model.Heightfield) -> Any:
    heights = np.asarray(value.heights, np.float64)
    if heights.ndim != 2:
        raise ValueError(f"heights has shape {heights.shape}, not (rows, columns)")
    rows, columns = heights.shape
    return wire.Heightfield(rows=rows, columns=columns, cell_size=value.cell_size, heights=heights.ravel().tolist())


def geometry(value: model.Geometry) -> Any:
    """Returns a Geometry message."""
    placed = value.position is not None or value.orientation is not None
    return wire.Geometry(
        id=value.id,
        shape=shape(value.shape),
        pose_in_entity=pose(value.position, value.orientation) if placed else None,
        material=material(
            friction=value.friction,
            kinetic_friction=value.kinetic_friction,
            restitution=value.restitution,
            density=value.density,
            friction_mixing=value.friction_mixing,
            restitution_mixing=value.restitution_mixing,
            rolling_friction=value.rolling_friction,
            spinning_friction=value.spinning_friction,
        ),
        category_bits=value.category_bits,
        collides_with_bits=value.collides_with_bits,
        is_sensor=value.sensor,
        collision_space=value.collision_space,
        surface_velocity=None
        if value.surface_velocity is None
        else vector(value.surface_velocity, "surface_velocity"),
    )


def inertia(mass: float | None, center_of_mass: Any, tensor: Any) -> Any:
    """Returns an Inertia message, or None if nothing is said; a tensor is 3 x 3 or xx xy xz yy yz zz."""
    if mass is None and center_of_mass is None and tensor is None:
        return None
    return wire.Inertia(
        mass=mass,
        center_of_mass=None if center_of_mass is None else vector(center_of_mass, "center_of_mass"),
        tensor=() if tensor is None else _tensor(tensor),
    )


def entity(
    *,
    name: str = "",
    position: Any = None,
    orientation: Any = None,
    physics: bool = True,
    geometries: Sequence[model.Geometry] = (),
    motion: str = "dynamic",
    mass: float | None = None,
    center_of_mass: Any = None,
    inertia_tensor: Any = None,
    linear_velocity: Any = None,
    angular_velocity: Any = None,
    linear_damping: float | None = None,
    angular_damping: float | None = None,
    gravity_scale: float | None = None,
    linear_speed_max: float | None = None,
    angular_speed_max: float | None = None,
    locked_axes: model.LockedAxes | None = None,
    auto_disable: model.AutoDisable | None = None,
    error_correction: model.ErrorCorrection | None = None,
    ignored_entities: Sequence[Any] = (),
    visual: model.Visual | None = None,
) -> Any:
    """Returns an Entity message from the keywords of `World.add_entity`."""
    body = None
    if physics:
        body = wire.RigidBody(
            motion_type=MOTION.number(motion),
            geometries=[geometry(each) for each in geometries],
            inertia=inertia(mass, center_of_mass, inertia_tensor),
            auto_disable=sleep_policy(auto_disable),
            error_correction=correction_policy(error_correction),
            linear_velocity=None if linear_velocity is None else vector(linear_velocity, "linear_velocity"),
            angular_velocity=None if angular_velocity is None else vector(angular_velocity, "angular_velocity"),
            linear_damping=linear_damping,
            angular_damping=angular_damping,
            gravity_scale=gravity_scale,
            linear_speed_max=linear_speed_max,
            angular_speed_max=angular_speed_max,
            locked_axes=None if locked_axes is None else wire.LockedAxes(**vars(locked_axes)),
            ignored_entity_ids=[entity_id(each) for each in ignored_entities],
        )
    placed = position is not None or orientation is not None
    return wire.Entity(
        display_name=name,
        pose=pose(position, orientation) if placed else None,
        rigid_body=body,
        visual=None if visual is None else wire.Visual(**vars(visual)),
    )


_ENTITY_PATHS = {"name": "display_name", "position": "pose", "orientation": "pose", "visual": "visual"}
_BODY_PATHS = {
    "motion": "motion_type",
    "mass": "inertia",
    "center_of_mass": "inertia",
    "inertia_tensor": "inertia",
    "ignored_entities": "ignored_entity_ids",
} | {
    name: name
    for name in (
        "geometries",
        "auto_disable",
        "error_correction",
        "linear_velocity",
        "angular_velocity",
        "linear_damping",
        "angular_damping",
        "gravity_scale",
        "linear_speed_max",
        "angular_speed_max",
        "locked_axes",
    )
}


def entity_update(options: dict[str, Any], whole: bool) -> tuple[Any, list[str]]:
    """Returns an Entity message of what `options` say, and the paths of what they are; with `whole`, all physics."""
    unknown = options.keys() - _ENTITY_PATHS.keys() - _BODY_PATHS.keys()
    if unknown:
        raise TypeError(f"an entity has no {', '.join(sorted(unknown))}")
    paths = [_ENTITY_PATHS[name] for name in options if name in _ENTITY_PATHS]
    parts = [f"rigid_body.{_BODY_PATHS[name]}" for name in options if name in _BODY_PATHS]
    paths += ["rigid_body"] if whole else parts
    return entity(physics=whole or bool(parts), **options), list(dict.fromkeys(paths))


def resource(collection: str, name: str) -> str:
    """Returns "worlds/lab" for "lab" and for "worlds/lab"."""
    return name if name.startswith(f"{collection}/") else f"{collection}/{name}"


def _numbers(value: Any, count: int, what: str) -> list[float]:
    numbers = [float(each) for each in value]
    if len(numbers) != count:
        raise ValueError(f"{what} has {len(numbers)} numbers, not {count}")
    return numbers


def _tensor(value: Any) -> list[float]:
    array = np.asarray(value, float)
    if array.shape == (3, 3):
        if not np.array_equal(array, array.T):
            raise ValueError("inertia_tensor is not symmetric")
        return [float(each) for each in array[np.triu_indices(3)]]
    return _numbers(value, 6, "inertia_tensor")

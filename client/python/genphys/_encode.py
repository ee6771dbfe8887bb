"""Python values -> messages. Kinds and shapes of arguments are checked here, their values by the server."""

from __future__ import annotations

import dataclasses
import difflib
import reprlib
import typing
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from . import _arguments, model
from ._arguments import instance, items
from ._contract import COORDINATES, FEATURE, MIXING, MOTION, QUALITY, SCALAR, SOLVER, make

_DTYPES = ("float32", "float64")
"""What the numbers of a frame may be; the contract has another word, for what is no frame."""


def vector(value: Any, what: str) -> Any:
    """Returns a Vector3; raises TypeError or ValueError unless `value` has three numbers."""
    x, y, z = _arguments.numbers(value, 3, what)
    return make.Vector3(x=x, y=y, z=z)


def quaternion(value: Any, what: str) -> Any:
    """Returns a Quaternion; raises TypeError or ValueError unless `value` has four numbers."""
    w, x, y, z = _arguments.numbers(value, 4, what)
    return make.Quaternion(w=w, x=x, y=y, z=z)


def pose(position: Any, orientation: Any) -> Any:
    """Returns a Pose; None leaves a part at its default."""
    return make.Pose(
        position=None if position is None else vector(position, "position"),
        orientation=None if orientation is None else quaternion(orientation, "orientation"),
    )


def entity_id(entity: Any, home: str) -> int:
    """Returns the id of an Entity or EntityInfo of the world `home`, or a number; raises for any other handle."""
    return _arguments.handle_id(entity, (model.Entity, model.EntityInfo), "an Entity", home)


def entity_ids(entities: Any, what: str, home: str) -> list[int]:
    """Returns the ids of entities; raises TypeError if they are not several."""
    return [entity_id(each, home) for each in items(entities, what)]


def entity_column(entities: Any, what: str, home: str) -> bytes:
    """Returns ids of entities as a byte column; an array of numbers takes the fast way."""
    return _arguments.id_column(entities, what, home, entity_id)


def frame(value: Any, what: str) -> Any:
    """Returns the Pose of a joint frame: a position, or a pair of position and orientation; None stays None."""
    if value is None:
        return None
    try:
        if isinstance(value, (tuple, list)) and len(value) == 2:
            return make.Pose(position=vector(value[0], what), orientation=quaternion(value[1], what))
        return make.Pose(position=vector(value, what))
    except TypeError:
        raise TypeError(f"{what} is {reprlib.repr(value)}, not a position or (position, orientation)") from None


def frame_request(frame: bool | model.FrameRequest | None, home: str) -> Any:
    """Returns a FrameRequest message; None when no frame is wanted."""
    if frame is None:
        return None
    if isinstance(frame, (bool, np.bool_)):
        return frame_request(model.FrameRequest(), home) if frame else None
    if not isinstance(frame, model.FrameRequest):
        raise TypeError(f"frame is {reprlib.repr(frame)}, not True, False or genphys.FrameRequest(...)")
    return make.FrameRequest(
        scalar=scalar(frame.dtype),
        poses=frame.poses,
        velocities=frame.velocities,
        net_forces=frame.net_forces,
        entity_ids=entity_ids(frame.entities, "entities", home),
        deltas=frame.deltas,
        joints=frame.joints,
    )


def scalar(dtype: Any) -> int:
    """Returns the number of what the numbers of a frame are: "float64", or a type or dtype of numpy."""
    word = np.dtype(dtype).name if isinstance(dtype, (np.dtype, type)) else dtype
    if not isinstance(word, str):
        raise TypeError(f"dtype is {reprlib.repr(dtype)}, not one of: {', '.join(_DTYPES)}")
    if word.lower() not in _DTYPES:
        raise ValueError(f"dtype is {dtype!r}, not one of: {', '.join(_DTYPES)}")
    return SCALAR.number(word)


def event_kinds(kinds: Any, what: str) -> Any:
    """Returns an EventKinds message."""
    return make.EventKinds(**vars(instance(kinds, model.EventKinds, what)))


def event_filter(events: bool | model.EventFilter | None, home: str, what: str = "events") -> Any:
    """Returns an EventFilter message; None when no events are wanted."""
    if events is None:
        return None
    if isinstance(events, (bool, np.bool_)):
        return make.EventFilter() if events else None
    if not isinstance(events, model.EventFilter):
        raise TypeError(f"{what} is {reprlib.repr(events)}, not True, False or genphys.EventFilter(...)")
    return make.EventFilter(
        kinds=None if events.kinds is None else event_kinds(events.kinds, "kinds"),
        entity_ids=entity_ids(events.entities, "entities", home),
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
    return make.Stepper(
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
    return [FEATURE.number(word) for word in items(words, "required_features")]


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
    return make.Material(
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
    instance(policy, model.AutoDisable, "auto_disable")
    return make.AutoDisable(
        enabled=policy.enabled,
        linear_speed_max=policy.linear_speed_max,
        angular_speed_max=policy.angular_speed_max,
        rest_time_seconds=policy.rest_time,
    )


def correction_policy(policy: model.ErrorCorrection | None) -> Any:
    """Returns an ErrorCorrection message, or None."""
    if policy is None:
        return None
    instance(policy, model.ErrorCorrection, "error_correction")
    return make.ErrorCorrection(
        time_constant_seconds=policy.time_constant,
        slop_metres=policy.slop,
        correction_speed_max=policy.correction_speed_max,
    )


_SHAPES = ", ".join(f"genphys.{kind.__name__}(...)" for kind in typing.get_args(model.Shape))


def shape(value: Any) -> Any:
    """Returns a Shape message; raises TypeError for what is no shape."""
    if isinstance(value, model.Sphere):
        return make.Shape(sphere=make.Sphere(radius=value.radius))
    if isinstance(value, model.Box):
        return make.Shape(box=make.Box(half_extents=vector(value.half_extents, "half_extents")))
    if isinstance(value, model.Capsule):
        return make.Shape(capsule=make.Capsule(radius=value.radius, half_length=value.half_length))
    if isinstance(value, model.Cylinder):
        return make.Shape(cylinder=make.Cylinder(radius=value.radius, half_length=value.half_length))
    if isinstance(value, model.Plane):
        return make.Shape(plane=make.Plane(normal=vector(value.normal, "normal"), offset=value.offset))
    if isinstance(value, model.Cone):
        return make.Shape(cone=make.Cone(radius=value.radius, half_length=value.half_length))
    if isinstance(value, model.Ellipsoid):
        return make.Shape(ellipsoid=make.Ellipsoid(semi_axes=vector(value.semi_axes, "semi_axes")))
    if isinstance(value, model.ConvexHull):
        return make.Shape(convex_hull=make.ConvexHull(vertices=_rows(value.vertices, "vertices")))
    if isinstance(value, model.TriangleMesh):
        indices = np.asarray(value.indices)
        if indices.ndim != 2 or indices.shape[1] != 3:
            raise ValueError(f"indices has shape {indices.shape}, not (n, 3)")
        mesh = make.TriangleMesh(vertices=_rows(value.vertices, "vertices"), indices=indices.ravel().tolist())
        return make.Shape(triangle_mesh=mesh)
    if isinstance(value, model.Heightfield):
        return make.Shape(heightfield=_heightfield(value))
    raise TypeError(f"shape is {reprlib.repr(value)}, not one of: {_SHAPES}")


def _rows(values: Any, what: str) -> Any:
    return _arguments.rows(values, 3, what).ravel().tolist()


def _heightfield(value: model.Heightfield) -> Any:
    heights = _arguments.floats(value.heights, "heights")
    if heights.ndim != 2:
        raise ValueError(f"heights has shape {heights.shape}, not (rows, columns)")
    rows, columns = heights.shape
    return make.Heightfield(rows=rows, columns=columns, cell_size=value.cell_size, heights=heights.ravel().tolist())


def geometry(value: Any, what: str = "geometry") -> Any:
    """Returns a Geometry message; raises TypeError for what is no Geometry, as a shape alone."""
    instance(value, model.Geometry, what)
    placed = value.position is not None or value.orientation is not None
    return make.Geometry(
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
    return make.Inertia(
        mass=mass,
        center_of_mass=None if center_of_mass is None else vector(center_of_mass, "center_of_mass"),
        tensor=() if tensor is None else _tensor(tensor),
    )


def entity(
    home: str,
    /,
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
        body = make.RigidBody(
            motion_type=MOTION.number(motion),
            geometries=[geometry(each, f"geometries[{i}]") for i, each in enumerate(items(geometries, "geometries"))],
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
            locked_axes=None
            if locked_axes is None
            else make.LockedAxes(**vars(instance(locked_axes, model.LockedAxes, "locked_axes"))),
            ignored_entity_ids=entity_ids(ignored_entities, "ignored_entities", home),
        )
    placed = position is not None or orientation is not None
    return make.Entity(
        display_name=name,
        pose=pose(position, orientation) if placed else None,
        rigid_body=body,
        visual=None if visual is None else make.Visual(**vars(instance(visual, model.Visual, "visual"))),
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


_NO_KEYWORDS = {"shape", "position", "orientation", "id"}  # of a geometry that is all there is of an entity
GEOMETRY_KEYWORDS = tuple(each.name for each in dataclasses.fields(model.Geometry) if each.name not in _NO_KEYWORDS)
BODY_KEYWORDS = tuple(_BODY_PATHS)
ENTITY_KEYWORDS = frozenset(entity.__kwdefaults__ or ())


def known(options: Iterable[str], keywords: Iterable[str], verb: str) -> None:
    """Raises TypeError, as Python does, unless all `options` are `keywords` of the method `verb`."""
    for name in options:
        if name not in keywords:
            near = difflib.get_close_matches(name, keywords, 1)
            meant = f"did you mean {near[0]!r}?" if near else f"help(genphys.World.{verb}) lists those that there are"
            raise TypeError(f"{verb}() got an unexpected keyword argument {name!r}: {meant}")


def entity_update(home: str, options: dict[str, Any], whole: bool) -> tuple[Any, list[str]]:
    """Returns an Entity message of what `options` say, and the paths of what they are; with `whole`, all physics."""
    for name in options:
        if name in GEOMETRY_KEYWORDS:
            raise TypeError(f"{name} is of a geometry: give all of these, as geometries=[genphys.Geometry({name}=...)]")
    known(options, ENTITY_KEYWORDS, "update_entity")
    paths = [_ENTITY_PATHS[name] for name in options if name in _ENTITY_PATHS]
    parts = [f"rigid_body.{_BODY_PATHS[name]}" for name in options if name in _BODY_PATHS]
    paths += ["rigid_body"] if whole else parts
    return entity(home, physics=whole or bool(parts), **options), list(dict.fromkeys(paths))


def cleared(names: Any) -> list[str]:
    """Returns the paths of what an update takes away; the contract's own are told as they are."""
    paths = {name: f"rigid_body.{path}" for name, path in _BODY_PATHS.items()}
    paths |= {**_ENTITY_PATHS, "physics": "rigid_body"}
    found = []
    for name in items(names, "clear"):
        if name not in paths and name not in paths.values():
            raise ValueError(f"clear has {reprlib.repr(name)}, not one of: {', '.join(sorted(paths))}")
        found.append(paths.get(name, name))
    return found


def resource(collection: str, name: Any, what: str) -> str:
    """Returns "worlds/lab" for "lab" and for "worlds/lab"; raises TypeError for what is no str."""
    if not isinstance(name, str):
        raise TypeError(f"{what} is {reprlib.repr(name)}, not a str")
    return name if name.startswith(f"{collection}/") else f"{collection}/{name}"


def _tensor(value: Any) -> Any:
    matrix = _arguments.floats(value, "inertia_tensor")
    if matrix.shape == (3, 3):
        if not np.array_equal(matrix, matrix.T):
            raise ValueError("inertia_tensor is not symmetric")
        return matrix[np.triu_indices(3)].tolist()
    return _arguments.numbers(value, 6, "inertia_tensor").tolist()

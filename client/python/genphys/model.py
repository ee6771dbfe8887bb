"""The values that describe a world: shapes, geometries, policies, and what the server tells about itself.

SI units throughout; right-handed axes with z up; quaternions are (w, x, y, z).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from ._arguments import Handle, id_in_batch

Vector = Union[Sequence[float], NDArray[np.float64]]
"""Three numbers: a tuple, a list, an array."""

Quaternion = Union[Sequence[float], NDArray[np.float64]]
"""Four numbers w, x, y, z of unit length."""


@dataclasses.dataclass(frozen=True)
class Sphere:
    """A ball around the origin of its frame; radius in metres."""

    radius: float = 0.5


@dataclasses.dataclass(frozen=True)
class Box:
    """A block around the origin, edges along the axes; half the length of each edge in metres."""

    half_extents: Vector = (0.5, 0.5, 0.5)


@dataclasses.dataclass(frozen=True)
class Capsule:
    """A cylinder along z with hemispheres at its ends; `half_length` is of the straight part; metres."""

    radius: float = 0.5
    half_length: float = 0.5


@dataclasses.dataclass(frozen=True)
class Cylinder:
    """A cylinder along z with flat ends; metres."""

    radius: float = 0.5
    half_length: float = 0.5


@dataclasses.dataclass(frozen=True)
class Plane:
    """A half space, solid where dot(normal, p) <= offset; offset in metres."""

    normal: Vector = (0.0, 0.0, 1.0)
    offset: float = 0.0


@dataclasses.dataclass(frozen=True)
class Cone:
    """Apex at z = half_length, base across z = -half_length; its centre of mass is at z = -half_length / 2; metres."""

    radius: float = 0.5
    half_length: float = 0.5


@dataclasses.dataclass(frozen=True)
class Ellipsoid:
    """Centred at the origin, axes along those of its frame; half the length of each axis in metres."""

    semi_axes: Vector = (0.5, 0.5, 0.5)


@dataclasses.dataclass(frozen=True)
class ConvexHull:
    """The smallest convex body around points: (n, 3), metres. Refused if they lie in a plane or nearly so."""

    vertices: Any

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ConvexHull) and np.array_equal(self.vertices, other.vertices)

    __hash__ = None  # type: ignore[assignment]


@dataclasses.dataclass(frozen=True)
class TriangleMesh:
    """A surface for static and kinematic entities, solid on the side from which its triangles are seen clockwise.

    Attributes:
        vertices: (n, 3), metres.
        indices: (m, 3): the vertices of each triangle, counted from 0.
    """

    vertices: Any
    indices: Any

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, TriangleMesh)
            and np.array_equal(self.vertices, other.vertices)
            and np.array_equal(self.indices, other.indices)
        )

    __hash__ = None  # type: ignore[assignment]


@dataclasses.dataclass(frozen=True)
class Heightfield:
    """A ground for static and kinematic entities, centred at the origin, solid below.

    Attributes:
        heights: (rows, columns): z of each grid point, metres; rows along y, columns along x.
        cell_size: Distance of neighbouring grid points, metres.
    """

    heights: Any
    cell_size: float = 1.0

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Heightfield)
            and self.cell_size == other.cell_size
            and np.array_equal(self.heights, other.heights)
        )

    __hash__ = None  # type: ignore[assignment]


@dataclasses.dataclass(frozen=True)
class UnknownShape:
    """A shape of a newer server that this version cannot describe."""

    kind: str = ""


Shape = Union[
    Sphere, Box, Capsule, Cylinder, Plane, Cone, Ellipsoid, ConvexHull, TriangleMesh, Heightfield
]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Geometry:
    """One form of an entity that collides. None leaves a value to the world's defaults.

    Attributes:
        shape: Its form.
        position: In the frame of the entity, metres.
        orientation: In the frame of the entity.
        friction: Coulomb coefficient at rest, 0 to 1000.
        kinetic_friction: Coulomb coefficient while sliding.
        restitution: Speed of separation over speed of approach, 0 to 1.
        density: kg/m^3.
        friction_mixing: How all coefficients of friction and the other side's become one: "geometric_mean",
            "average", "minimum", "multiply" or "maximum". Of two different rules the one further to the right counts.
        restitution_mixing: The same for restitution.
        rolling_friction: Largest torque against rolling over the normal force, metres; both sides need some unless
            friction_mixing says otherwise.
        spinning_friction: The same against spinning about the normal.
        sensor: Reports overlaps and pushes nothing.
        collision_space: Members of one space never collide with each other; "car/wheels" is inside "car".
        category_bits: The categories that it belongs to, one bit each.
        collides_with_bits: The categories that it collides with; both of a pair must agree.
        surface_velocity: How its surface runs over it, m/s, in its own frame: a conveyor belt.
        id: Its number in the entity; zero when the server shall choose.
    """

    shape: Shape | UnknownShape
    position: Vector | None = None
    orientation: Quaternion | None = None
    friction: float | None = None
    kinetic_friction: float | None = None
    restitution: float | None = None
    density: float | None = None
    friction_mixing: str | None = None
    restitution_mixing: str | None = None
    rolling_friction: float | None = None
    spinning_friction: float | None = None
    sensor: bool = False
    collision_space: str = ""
    category_bits: int | None = None
    collides_with_bits: int | None = None
    surface_velocity: Vector | None = None
    id: int = 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class AutoDisable:
    """When a resting entity falls asleep. None leaves a value to the world's defaults.

    Attributes:
        enabled: Whether it may.
        linear_speed_max: Speed below which it rests, m/s.
        angular_speed_max: Rate of rotation below which it rests, rad/s.
        rest_time: How long it rests before it sleeps, seconds.
    """

    enabled: bool | None = None
    linear_speed_max: float | None = None
    angular_speed_max: float | None = None
    rest_time: float | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class ErrorCorrection:
    """How overlaps and the gaps of joints are taken away. None leaves a value to the world or the engine.

    Attributes:
        time_constant: In which a violation falls to 1 / e, seconds; zero: at once, in each substep.
        correction_speed_max: Fastest speed at which it is taken away, m/s.
        slop: Part of it that is left alone, metres.
    """

    time_constant: float | None = None
    correction_speed_max: float | None = None
    slop: float | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class LockedAxes:
    """Axes of the world along which the centre of mass of a dynamic entity does not move, and about which it does not
    turn, whatever pushes it.

    Attributes:
        linear_x: No motion along x; so the next two.
        angular_x: No rotation about x; so the next two.
    """

    linear_x: bool = False
    linear_y: bool = False
    linear_z: bool = False
    angular_x: bool = False
    angular_y: bool = False
    angular_z: bool = False


@dataclasses.dataclass(frozen=True, kw_only=True)
class Visual:
    """What a renderer should draw; the server carries it and never looks inside.

    Attributes:
        uri: Where to find it.
        media_type: Of the data or of what the uri names, as in "model/gltf-binary".
        data: The thing itself.
    """

    uri: str = ""
    media_type: str = ""
    data: bytes = b""


@dataclasses.dataclass(frozen=True, kw_only=True)
class EventKinds:
    """Which kinds of events a world records; the defaults are those of the server.

    Attributes:
        contacts: Contacts that begin and end.
        persisting_contacts: Contacts that last, once per step and pair; recorded where the world was told to.
        contact_points: The points of contacts that begin or last.
        sensors: Sensors entered and left.
        sleeping: Falling asleep and waking up.
        moving: Starting and stopping to move or to rotate; likewise.
        joints: Joints that break.
        changes: Entities, joints and force fields created, updated and deleted, and entities faulted.
    """

    contacts: bool = True
    persisting_contacts: bool = False
    contact_points: bool = True
    sensors: bool = True
    sleeping: bool = True
    moving: bool = False
    joints: bool = True
    changes: bool = True


@dataclasses.dataclass(frozen=True, kw_only=True)
class EventFilter:
    """Which events one listener wants.

    Attributes:
        kinds: Unset: all that the world records. Of what it does not record nothing comes, whatever is wanted here: that
            is said by `create_world(recorded_events=...)`, and told by `World.info().recorded_events`.
        entities: Events that name one of these (`Entity` or id); empty: all.
    """

    kinds: EventKinds | None = None
    entities: Sequence[object] = ()


@dataclasses.dataclass(frozen=True, kw_only=True)
class FrameRequest:
    """Which columns a frame shall have; what is not asked for is neither computed nor sent.

    Attributes:
        poses: Positions and orientations.
        velocities: Linear and angular velocities.
        net_forces: Forces and torques that acted in the last step.
        entities: Rows of these (`Entity` or id) alone; empty: all.
        dtype: "float64" or "float32", or these as numpy has them.
        joints: What all joints of the world do.
        deltas: Only what changed since an earlier frame is sent; the frames you get are whole all the same.
    """

    poses: bool = True
    velocities: bool = True
    net_forces: bool = False
    entities: Sequence[object] = ()
    dtype: str | type | np.dtype[Any] = "float64"
    deltas: bool = False
    joints: bool = False


class Entity(Handle):
    """A handle of one entity: its id in its world, and a name for people.

    Handles compare and hash by id. Those of two worlds may be equal by chance; a world takes none of another one's.
    """

    __slots__ = ("_id", "_name")

    def __init__(self, id: int | None, name: str = "", home: str = "") -> None:
        super().__init__(home)
        self._id = id
        self._name = name

    @property
    def id(self) -> int:
        """The id; of an entity created in a batch, there only after the step that took the batch along.

        Raises:
            ValueError: the batch has not been taken along yet, or was refused.
        """
        return id_in_batch(self, str(self), ": until then only its own batch can name it, in joints and fields")

    @property
    def name(self) -> str:
        """The display name if this client knows it, else empty."""
        return self._name

    def __index__(self) -> int:
        return self.id

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Entity):
            return NotImplemented
        return self is other or (self._id is not None and self._id == other._id)

    def __hash__(self) -> int:
        return hash(self.id)

    def __str__(self) -> str:
        return self._name or ("a new entity" if self._id is None else f"entity {self._id}")

    def __repr__(self) -> str:
        return f"<{self._name or 'entity'} {self._id}>"


@dataclasses.dataclass(frozen=True, kw_only=True)
class EntityInfo(Handle):
    """One entity as it was when asked for. Accepted wherever an `Entity` is.

    Attributes:
        entity: Its handle.
        name: For people.
        position: Of its frame in the world, metres.
        orientation: Of its frame in the world.
        physics: Whether it has a rigid body; the fields below mean nothing without.
        motion: "static", "kinematic" or "dynamic".
        linear_velocity: Of the centre of mass, m/s.
        angular_velocity: rad/s.
        mass: kg; None if the server did not say.
        geometries: What it collides with.
        visual: What to draw; None if there is nothing.
        locked_axes: Where it cannot go.
        error_correction: How its overlaps and the gaps of its joints are taken away.
        ignored_entities: Ids of those that it and they never touch, as it names them.
    """

    entity: Entity
    name: str
    position: tuple[float, float, float]
    orientation: tuple[float, float, float, float]
    physics: bool
    motion: str
    linear_velocity: tuple[float, float, float]
    angular_velocity: tuple[float, float, float]
    mass: float | None
    geometries: tuple[Geometry, ...]
    visual: Visual | None
    locked_axes: LockedAxes = LockedAxes()
    error_correction: ErrorCorrection = ErrorCorrection()
    ignored_entities: tuple[int, ...] = ()

    @property
    def id(self) -> int:
        """The id of the entity in its world."""
        return self.entity.id

    @property
    def _home(self) -> str:
        return self.entity._home

    def __index__(self) -> int:
        return self.entity.id


@dataclasses.dataclass(frozen=True, kw_only=True)
class EngineInfo:
    """One physics engine of a server: its name as in "ode", version, and features in lower case as in "shape_box"."""

    name: str
    version: str
    features: frozenset[str]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Stamp:
    """When something was true: steps taken, simulated seconds, and the epoch, which is new after every reset."""

    step: int
    time: float
    epoch: int
    state_hash: int | None


@dataclasses.dataclass(frozen=True, kw_only=True)
class WorldInfo:
    """One world as it was when asked for.

    Attributes:
        name: As in "lab".
        engine: As in "ode"; "none" when detached.
        state: "paused", "playing" or "faulted".
        gravity: m/s^2.
        step_size: Seconds.
        stamp: When this was true.
        recorded_events: Which kinds of events happen at all.
    """

    name: str
    engine: str
    state: str
    gravity: tuple[float, float, float]
    step_size: float
    stamp: Stamp
    recorded_events: EventKinds = EventKinds()


@dataclasses.dataclass(frozen=True, kw_only=True)
class RayHits:
    """The first hit of each ray; row i belongs to ray i.

    Attributes:
        hit: Whether there is one.
        entity_ids: Whom it hit; zero without a hit.
        fractions: 0 to 1 along the translation; 1 without a hit.
        normals: Unit length, out of the surface; zero without a hit.
        points: Where, in world coordinates, metres; the end of the ray without a hit.
    """

    hit: NDArray[np.bool_]
    entity_ids: NDArray[np.uint64]
    fractions: NDArray[np.float64]
    normals: NDArray[np.float64]
    points: NDArray[np.float64]

"""The verbs that change a world: done at once by a `World`, collected by a `Batch`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from . import _arguments, _encode, fields, joints, model
from ._contract import make, wire
from .joints import Joint
from .model import Entity, Quaternion, Vector
from .options import EntityOptions, ShapeOptions, explained

if TYPE_CHECKING:
    from typing_extensions import Unpack

_OF_WHAT_MOVES = (
    "mass",
    "density",
    "center_of_mass",
    "inertia_tensor",
    "linear_damping",
    "angular_damping",
    "gravity_scale",
    "linear_speed_max",
    "angular_speed_max",
    "locked_axes",
    "auto_disable",
)
_SHAPE_KEYWORDS = (_encode.ENTITY_KEYWORDS - {"geometries", "physics"}) | set(_encode.GEOMETRY_KEYWORDS)


class Commands:
    """The verbs. Everything is in SI units and, unless said otherwise, in world coordinates.

    All raise a subclass of `GenphysError` when the server refuses, and ValueError or TypeError for arguments that
    have no meaning at all, like a position of two numbers. In a batch the server refuses when the batch is taken
    along, with the place of the command in `argument`.
    """

    _home: str
    """The name of the world that handles must be of."""

    def _create(self, entity: Any, verb: str = "") -> Entity:
        """Makes it; `verb` is what makes an entity of one shape, which errors then call as its arguments do."""
        raise NotImplementedError

    def _create_field(self, command: Any) -> fields.ForceField:
        raise NotImplementedError

    def _made_by(self, entity: Any) -> int | None:
        """Returns the place in the batch of the command that makes an entity which is not there yet."""
        return None

    def _submit(self, *commands: Any) -> None:
        """Does them, in this order, or none of them."""
        raise NotImplementedError

    def _join(self, joint: Any) -> Joint:
        raise NotImplementedError

    def _side(self, entity: Entity | int | None) -> Any:
        return None if entity is None else wire.EntityRef(id=_encode.entity_id(entity, self._home))

    def join(
        self,
        entity_a: Entity | int | None,
        entity_b: Entity | int | None,
        kind: joints.Kind,
        *,
        frame_in_a: Any = None,
        frame_in_b: Any = None,
        collide_connected: bool = False,
        break_force: float | None = None,
        break_torque: float | None = None,
    ) -> Joint:
        """Joins two entities, or one to the world.

        Args:
            entity_a: One side; None is the world.
            entity_b: The other side; None is the world.
            kind: As in `genphys.joints.Hinge(upper=1.0)`.
            frame_in_a: The joint frame in a: a position in metres, or (position, orientation). None is where the
                frame in b is now; of a distance and a gear the frame of the entity.
            frame_in_b: The same in b; when both are None it is the frame of the entity.
            collide_connected: Whether both may touch each other.
            break_force: N that it holds at most; None is any.
            break_torque: N*m about the origin of frame b that it holds at most; None is any.
        """
        joint = make.Joint(
            entity_a=self._side(entity_a),
            entity_b=self._side(entity_b),
            frame_in_a=_encode.frame(frame_in_a, "frame_in_a"),
            frame_in_b=_encode.frame(frame_in_b, "frame_in_b"),
            collide_connected=collide_connected,
            break_force=break_force,
            break_torque=break_torque,
            **joints.encode(kind),
        )
        return self._join(joint)

    def change_joint(
        self,
        joint: Joint | int,
        kind: joints.Kind | None = None,
        *,
        frame_in_a: Any = None,
        frame_in_b: Any = None,
        collide_connected: bool | None = None,
        break_force: float | None = None,
        break_torque: float | None = None,
    ) -> None:
        """Changes a joint that holds; what is None stays as it is, and so do the entities.

        Args:
            joint: Which one.
            kind: Replaces all that the kind says, or makes it another kind.
            frame_in_a: The joint frame in a: a position in metres, or (position, orientation).
            frame_in_b: The same in b.
            collide_connected: Whether both may touch each other.
            break_force: N that it holds at most; `math.inf` is any.
            break_torque: N*m about the origin of frame b that it holds at most; `math.inf` is any.
        """
        given = {
            "frame_in_a": _encode.frame(frame_in_a, "frame_in_a"),
            "frame_in_b": _encode.frame(frame_in_b, "frame_in_b"),
            "collide_connected": collide_connected,
            "break_force": break_force,
            "break_torque": break_torque,
        }
        fields = {} if kind is None else joints.encode(kind)
        fields |= {name: value for name, value in given.items() if value is not None}
        # A field that is named and not set is as it was when nobody said anything of it.
        said = {name: value for name, value in fields.items() if value != math.inf}
        if kind is None:
            # A joint without a kind is refused; one that the mask does not name is not looked at.
            said["fixed"] = wire.FixedJoint()
        update = wire.UpdateJoint(joint=make.Joint(id=joints.joint_id(joint, self._home), **said))
        update.update_mask.paths.extend(fields)
        self._submit(wire.Command(update_joint=update))

    def remove_joint(self, joint: Joint | int) -> None:
        """Removes a joint."""
        self._submit(wire.Command(delete_joint=wire.DeleteJoint(joint_id=joints.joint_id(joint, self._home))))

    def set_motors(self, of: Iterable[Joint | int] | Any, velocities: Any, positions: Any = None) -> None:
        """Sets the targets of the first motor of many joints: the fast way.

        Args:
            of: n joints or an array of n ids; of none nothing is done.
            velocities: (n,), m/s or rad/s.
            positions: (n,), m or rad, when all of them drive to a position; None leaves them.
        """
        columns = make.SetMotorColumns(
            joint_ids=joints.joint_column(of, "of", self._home),
            targets=_arguments.number_column(velocities, "velocities"),
            positions=b"" if positions is None else _arguments.number_column(positions, "positions"),
        )
        if _has_rows(columns.joint_ids, velocities=columns.targets, positions=columns.positions):
            self._submit(wire.Command(set_motors=columns))

    @explained(ShapeOptions)
    def add_sphere(self, *, radius: float = 0.5, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a ball of this radius in metres.

        Without mass or density the world's default density counts.
        """
        return self._add("add_sphere", model.Sphere(radius), options)

    @explained(ShapeOptions)
    def add_box(self, *, half_extents: Vector = (0.5, 0.5, 0.5), **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a block with these half edges in metres."""
        return self._add("add_box", model.Box(half_extents), options)

    @explained(ShapeOptions)
    def add_capsule(self, *, radius: float = 0.5, half_length: float = 0.5, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a cylinder along its z with round ends; `half_length` in metres is of the straight part."""
        return self._add("add_capsule", model.Capsule(radius, half_length), options)

    @explained(ShapeOptions)
    def add_cylinder(self, *, radius: float = 0.5, half_length: float = 0.5, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a cylinder along its z with flat ends; metres."""
        return self._add("add_cylinder", model.Cylinder(radius, half_length), options)

    @explained(ShapeOptions)
    def add_cone(self, *, radius: float = 0.5, half_length: float = 0.5, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a cone with its apex at its z = half_length and its base across -half_length; metres."""
        return self._add("add_cone", model.Cone(radius, half_length), options)

    @explained(ShapeOptions)
    def add_ellipsoid(self, *, semi_axes: Vector = (0.5, 0.5, 0.5), **options: Unpack[ShapeOptions]) -> Entity:
        """Adds an ellipsoid with these half axes in metres."""
        return self._add("add_ellipsoid", model.Ellipsoid(semi_axes), options)

    @explained(ShapeOptions)
    def add_convex_hull(self, vertices: Any, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds the smallest convex body around (n, 3) points in metres."""
        return self._add("add_convex_hull", model.ConvexHull(vertices), options)

    @explained(ShapeOptions)
    def add_mesh(self, vertices: Any, indices: Any, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a static (or, with motion="kinematic", kinematic) surface of triangles; see `TriangleMesh`."""
        return self._add_ground("add_mesh", model.TriangleMesh(vertices, indices), options)

    @explained(ShapeOptions)
    def add_heightfield(self, heights: Any, *, cell_size: float = 1.0, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a static (or, with motion="kinematic", kinematic) ground of heights; see `Heightfield`."""
        return self._add_ground("add_heightfield", model.Heightfield(heights, cell_size), options)

    @explained(ShapeOptions)
    def add_plane(
        self, *, normal: Vector = (0.0, 0.0, 1.0), offset: float = 0.0, **options: Unpack[ShapeOptions]
    ) -> Entity:
        """Adds a static half space, solid where dot(normal, p) <= offset; offset in metres."""
        return self._add_ground("add_plane", model.Plane(normal, offset), options)

    @explained(EntityOptions)
    def add_entity(
        self, *, geometries: Sequence[model.Geometry] = (), physics: bool = True, **options: Unpack[EntityOptions]
    ) -> Entity:
        """Adds an entity with any number of geometries, or without physics.

        Args:
            geometries: What it collides with; without any it needs a mass.
            physics: False for something that stays where it is put and collides with nothing.
            options: See below.
        """
        _encode.known(options, _encode.ENTITY_KEYWORDS, "add_entity")
        if not physics:
            told = {**options, "geometries": geometries or None}
            _refuse(told, _encode.BODY_KEYWORDS, "physics=False makes what has no body")
        return self._create(_encode.entity(self._home, geometries=geometries, physics=physics, **options))

    @explained(EntityOptions)
    def update_entity(
        self,
        entity: Entity | int,
        *,
        clear: Sequence[str] = (),
        **options: Any,
    ) -> None:
        """Changes a live entity: what is given is replaced, the rest stays.

        Args:
            entity: Which.
            clear: Keywords whose values it loses or takes back to their defaults: "mass", "visual", "physics" ...
            options: Keywords of `add_entity`. geometries are all that it has from then on: keep the id of one that
                stays; of one that is changed too. A mass, centre or tensor replaces all three. A position or an
                orientation alone leaves the other one, as `set_pose` does; None leaves it, too. Physics comes to an
                entity without by physics=True, with all that belongs to it.
        """
        pose = {name: options.pop(name, None) for name in ("position", "orientation")}
        halves = [name for name, value in pose.items() if value is not None]
        if len(halves) == 2:
            options |= pose
        whole = options.pop("physics", None)
        if whole is False:
            _refuse(options, _encode.BODY_KEYWORDS, "physics=False takes the body away")
        cleared = [*_encode.cleared(clear), *(["rigid_body"] if whole is False else [])]
        message, paths = _encode.entity_update(self._home, options, whole=bool(whole))
        message.id = _encode.entity_id(entity, self._home)
        commands = []
        if paths or cleared or not halves:
            update = wire.UpdateEntity(entity=message)
            update.update_mask.paths.extend([*paths, *cleared])
            commands.append(wire.Command(update_entity=update))
        if len(halves) == 1:
            # An update replaces the whole pose. After it, so that a half is not lost to what it clears.
            half = make.SetPose(entity_id=message.id, pose=_encode.pose(**pose))
            commands.append(wire.Command(set_pose=half))
        self._submit(*commands)

    def remove(self, entity: Entity | int) -> None:
        """Removes an entity and the joints that hold it."""
        self._submit(wire.Command(delete_entity=wire.DeleteEntity(entity_id=_encode.entity_id(entity, self._home))))

    def apply_force(
        self,
        entity: Entity | int,
        force: Vector | None = None,
        *,
        torque: Vector | None = None,
        point: Vector | None = None,
        coordinates: str = "world",
        steps: int | None = None,
        replace: bool = False,
        sampled: bool = False,
    ) -> None:
        """Pushes an entity from the next step on.

        Args:
            entity: Whom.
            force: N.
            torque: N*m.
            point: Where the force acts, metres; None is the centre of mass.
            coordinates: Of force, torque and point: "world" or "entity".
            steps: How many steps it acts; None is one.
            replace: Drop this entity's other pending forces first; otherwise they add up.
            sampled: It is a sample of a course, of which another one is sent for each step, as a controller does: it is
                taken to go straight from one to the next, and motion under it is of second order. Otherwise the force
                stays as it is and jumps, which is exact for what does.
        """
        _acts(force=force, torque=torque, point=point)
        whom = _encode.entity_id(entity, self._home)
        force_of_entity = _force(whom, force, torque, point, coordinates, steps, replace, sampled)
        self._submit(wire.Command(apply_force=force_of_entity))

    def apply_impulse(
        self,
        entity: Entity | int,
        linear: Vector | None = None,
        *,
        angular: Vector | None = None,
        point: Vector | None = None,
        coordinates: str = "world",
    ) -> None:
        """Changes the momentum of an entity at once.

        Args:
            entity: Whose.
            linear: N*s.
            angular: N*m*s.
            point: Where the linear impulse acts, metres; None is the centre of mass.
            coordinates: Of all three: "world" or "entity".
        """
        _acts(linear=linear, angular=angular, point=point)
        impulse = make.ApplyImpulse(
            entity_id=_encode.entity_id(entity, self._home),
            linear=None if linear is None else _encode.vector(linear, "linear"),
            angular=None if angular is None else _encode.vector(angular, "angular"),
            point=None if point is None else _encode.vector(point, "point"),
            coordinates=_encode.coordinates(coordinates),
        )
        self._submit(wire.Command(apply_impulse=impulse))

    def apply_forces(
        self, entities: Iterable[Entity | int] | Any, forces: Any = None, torques: Any = None, *, sampled: bool = False
    ) -> None:
        """Pushes many entities for one step, at their centres of mass: the fast way.

        Args:
            entities: n entities or an array of n ids; on none nothing is done.
            forces: (n, 3), N; None for none.
            torques: (n, 3), N*m; None for none.
            sampled: As in `apply_force`.
        """
        if forces is None and torques is None:
            raise ValueError("give forces, torques or both")
        columns = make.ApplyForceColumns(
            entity_ids=_encode.entity_column(entities, "entities", self._home),
            forces=b"" if forces is None else _arguments.row_column(forces, 3, "forces"),
            torques=b"" if torques is None else _arguments.row_column(torques, 3, "torques"),
            sampled=sampled,
        )
        if _has_rows(columns.entity_ids, forces=columns.forces, torques=columns.torques):
            self._submit(wire.Command(apply_forces=columns))

    def add_field(
        self,
        field: fields.Field,
        *,
        entities: Sequence[Entity | int] = (),
        region: tuple[Vector, Vector] | None = None,
    ) -> fields.ForceField:
        """Adds a force that acts until it is removed, as in `world.add_field(genphys.fields.Drag(linear=0.5))`.

        Args:
            field: What it does; see `genphys.fields`.
            entities: On which; empty: all dynamic ones. A spring names its own.
            region: Two opposite corners, metres: only on entities whose centre of mass is inside.
        """
        return self._create_field(fields.creation(self._home, field, entities, region, self._made_by))

    def update_field(
        self,
        number: fields.ForceField | int,
        field: fields.Field,
        *,
        entities: Sequence[Entity | int] = (),
        region: tuple[Vector, Vector] | None = None,
    ) -> None:
        """Replaces all of a force field; see `add_field`."""
        message = fields.message(self._home, field, entities, region, fields.field_id(number, self._home))
        self._submit(wire.Command(update_force_field=wire.UpdateForceField(field=message)))

    def remove_field(self, number: fields.ForceField | int) -> None:
        """Removes a force field."""
        which = fields.field_id(number, self._home)
        self._submit(wire.Command(delete_force_field=wire.DeleteForceField(field_id=which)))

    def set_velocity(
        self, entity: Entity | int, *, linear: Vector | None = None, angular: Vector | None = None
    ) -> None:
        """Sets the velocity of the centre of mass in m/s and the spin in rad/s; None leaves one as it is."""
        velocity = make.SetVelocity(
            entity_id=_encode.entity_id(entity, self._home),
            linear=None if linear is None else _encode.vector(linear, "linear"),
            angular=None if angular is None else _encode.vector(angular, "angular"),
        )
        self._submit(wire.Command(set_velocity=velocity))

    def set_pose(
        self,
        entity: Entity | int,
        *,
        position: Vector | None = None,
        orientation: Quaternion | None = None,
        over_steps: int = 0,
    ) -> None:
        """Puts an entity somewhere else, or leads a kinematic one there; None leaves one as it is.

        Joints of who is turned otherwise at once count their turns anew, from -pi to pi or near the middle of limits.

        Args:
            entity: Whom.
            position: Metres.
            orientation: (w, x, y, z).
            over_steps: In how many steps a kinematic entity goes there, evenly, pushing what is in its way with the
                velocity that this takes; then it stands. 0: it is there at once, its velocity stays, and what it
                overlaps there is only pushed out of it.
        """
        pose = _encode.pose(position, orientation)
        command = make.SetPose(entity_id=_encode.entity_id(entity, self._home), pose=pose, over_steps=over_steps)
        self._submit(wire.Command(set_pose=command))

    def set_gravity(self, gravity: Vector) -> None:
        """Changes the gravity of the world, m/s^2."""
        self._submit(wire.Command(set_gravity=wire.SetGravity(gravity=_encode.vector(gravity, "gravity"))))

    def set_engine(self, engine: str) -> None:
        """Moves the running world to another engine, state kept; "none" detaches it, then nothing moves.

        Args:
            engine: As in "bullet"; see `Server.engines`.
        """
        self._submit(wire.Command(set_engine=wire.SetEngine(engine=_encode.resource("engines", engine, "engine"))))

    def set_stepper(
        self,
        *,
        step_size: float | None = None,
        quality: str | None = None,
        solver: str | None = None,
        substeps: int | None = None,
        iterations: int | None = None,
        engine_only: bool = False,
    ) -> None:
        """Changes how time advances; what is None takes the server's default, not its old value.

        Args:
            step_size: Seconds of one step.
            quality: "fast", "balanced" or "accurate": a preset of what follows.
            solver: "iterative" or "direct".
            substeps: Equal parts of a step.
            iterations: Sweeps of an iterative solver in each of them.
            engine_only: Bodies that fly with nothing near go through the engine too: slower, to compare.
        """
        stepper = _encode.stepper(step_size, quality, solver, substeps, iterations, engine_only)
        self._submit(wire.Command(set_stepper=wire.SetStepper(stepper=stepper)))

    def _add_ground(self, verb: str, shape: model.Shape, options: Any) -> Entity:
        options.setdefault("motion", "static")
        # Whether an engine moves such a shape is for the server to say, but nobody moves what shall not be dynamic.
        if str(options["motion"]).lower() != "dynamic":
            _refuse(options, _OF_WHAT_MOVES, f"{verb} makes what nothing pushes")
        return self._add(verb, shape, options)

    def _add(self, verb: str, shape: model.Shape, options: Any) -> Entity:
        _encode.known(options, _SHAPE_KEYWORDS, verb)
        if options.get("mass") is not None and options.get("density") is not None:
            raise ValueError("give mass or density, not both")
        of_geometry = {key: options.pop(key) for key in _encode.GEOMETRY_KEYWORDS if key in options}
        geometry = model.Geometry(shape=shape, **of_geometry)
        return self._create(_encode.entity(self._home, geometries=[geometry], **options), verb)


def _refuse(options: Any, keywords: Iterable[str], why: str) -> None:
    """Raises ValueError for what would be left out in silence."""
    for name in keywords:
        if options.get(name) is not None:
            raise ValueError(f"{name} has no effect here: {why}")


def _has_rows(ids: bytes, **columns: bytes) -> bool:
    """Returns whether there is something to do; raises ValueError for rows of nobody."""
    for name, column in columns.items():
        if column and not ids:
            raise ValueError(f"{name} has rows, but nobody is named")
    return bool(ids)


def _acts(*, point: Vector | None, **pushes: Vector | None) -> None:
    """Raises ValueError for what pushes nobody: `pushes` are what acts at the point and what turns."""
    straight, _ = pushes
    if all(push is None for push in pushes.values()):
        raise ValueError(f"give {' or '.join(pushes)}")
    if point is not None and pushes[straight] is None:
        raise ValueError(f"point has no effect here: it is where {straight} acts")


def _force(
    number: int,
    force: Vector | None,
    torque: Vector | None,
    point: Vector | None,
    coordinates: str,
    steps: int | None,
    replace: bool,
    sampled: bool,
) -> Any:
    return make.ApplyForce(
        entity_id=number,
        force=None if force is None else _encode.vector(force, "force"),
        torque=None if torque is None else _encode.vector(torque, "torque"),
        point=None if point is None else _encode.vector(point, "point"),
        coordinates=_encode.coordinates(coordinates),
        steps=steps,
        replace=replace,
        sampled=sampled,
    )

"""The verbs that change a world: done at once by a `World`, collected by a `Batch`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from . import _arguments, _encode, fields
from ._contract import make, wire
from ._entity_verbs import EntityVerbs
from ._joint_verbs import JointVerbs
from ._verbs import has_rows
from .model import Entity, Quaternion, Vector


class Commands(EntityVerbs, JointVerbs):
    """The verbs. Everything is in SI units and, unless said otherwise, in world coordinates.

    All raise a subclass of `GenphysError` when the server refuses, and ValueError or TypeError for arguments that
    have no meaning at all, like a position of two numbers. In a batch the server refuses when the batch is taken
    along, with the place of the command in `argument`.
    """

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
        if has_rows(columns.entity_ids, forces=columns.forces, torques=columns.torques):
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

"""The verbs that change joints."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from . import _arguments, _encode, joints
from ._contract import make, wire
from ._verbs import Verbs, has_rows
from .joints import Joint
from .model import Entity


class JointVerbs(Verbs):
    """Those of `Commands`."""

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
        if has_rows(columns.joint_ids, velocities=columns.targets, positions=columns.positions):
            self._submit(wire.Command(set_motors=columns))

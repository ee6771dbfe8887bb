"""What joints are: the kinds, and what acts on the coordinates that they leave free.

Along an axis values are in metres, m/s, N, N/m and N*s/m; about one they are in radians, rad/s, N*m, N*m/rad and
N*m*s/rad. Each kind is told in the joint frames, one fixed in entity a and one in entity b.
"""

from __future__ import annotations

import dataclasses
import reprlib
import typing
from typing import Any, Union

from . import _arguments
from ._arguments import Handle, instance
from ._contract import make


@dataclasses.dataclass(frozen=True, kw_only=True)
class Motor:
    """Drives a coordinate to a velocity, or by a spring and damper to a position.

    It is held as it is told for the whole of each step. Who follows a course, and tells another position for each step,
    tells that of the middle of the step: told that of its end, the coordinate runs ahead by up to half a step.

    Attributes:
        velocity: Target, of b against a.
        position: Target; None drives to the velocity alone.
        stiffness: Of the drive to a position; more than zero there.
        damping: Of the drive to a position, against the target velocity.
        force_max: Largest force or torque of either sign; None is as much as it takes.
    """

    velocity: float = 0.0
    position: float | None = None
    stiffness: float = 0.0
    damping: float = 0.0
    force_max: float | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Spring:
    """Pulls a coordinate to `rest`."""

    stiffness: float = 0.0
    damping: float = 0.0
    rest: float = 0.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Axis:
    """A coordinate that is free between `lower` and `upper`, and what acts on it."""

    lower: float | None = None
    upper: float | None = None
    motor: Motor | None = None
    spring: Spring | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Ball:
    """Point to point: the origins of both frames stay together.

    Attributes:
        swing_max: Largest angle between both z axes.
        twist_lower: Of the rotation about z.
        twist_upper: Of the rotation about z.
    """

    swing_max: float | None = None
    twist_lower: float | None = None
    twist_upper: float | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Hinge(Axis):
    """Point to nail: b rotates about z of the joint frame."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Slider(Axis):
    """Point to path: b slides along z of frame a and does not turn."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Universal:
    """b rotates about x of frame a and about y of frame b, which stay perpendicular."""

    about_x: Axis | None = None
    about_y: Axis | None = None


@dataclasses.dataclass(frozen=True)
class Fixed:
    """Both frames stay together."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Wheel:
    """b is a wheel of a.

    Attributes:
        suspension: Along z of frame a; None is none.
        steering: About that z; None is straight ahead.
        spin: About y of frame b; None is free.
    """

    suspension: Axis | None = None
    steering: Axis | None = None
    spin: Axis | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class SixDof:
    """What is None is held at zero; an empty Axis is free."""

    along_x: Axis | None = None
    along_y: Axis | None = None
    along_z: Axis | None = None
    about_x: Axis | None = None
    about_y: Axis | None = None
    about_z: Axis | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Distance(Axis):
    """Acts on the distance between the origins of both frames; with nothing set it keeps the present one."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Gear:
    """b rotates about z of its frame `ratio` times as fast as a about z of its own, both against the world."""

    ratio: float = 1.0


@dataclasses.dataclass(frozen=True)
class UnknownKind:
    """A joint of a newer server that this version cannot describe."""

    kind: str = ""


Kind = Union[Ball, Hinge, Slider, Universal, Fixed, Wheel, SixDof, Distance, Gear]


class Joint(Handle):
    """A handle of one joint: its id in its world."""

    __slots__ = ("_id",)

    def __init__(self, id: int | None, home: str = "") -> None:
        super().__init__(home)
        self._id = id

    @property
    def id(self) -> int:
        """The id; of a joint made in a batch, there only after the step that took the batch along.

        Raises:
            ValueError: the batch has not been taken along yet, or was refused.
        """
        return _arguments.id_in_batch(self, "a new joint")

    def __index__(self) -> int:
        return self.id

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Joint):
            return NotImplemented
        return self is other or (self._id is not None and self._id == other._id)

    def __hash__(self) -> int:
        return hash(self.id)

    def __repr__(self) -> str:
        return f"<Joint {self._id}>"


@dataclasses.dataclass(frozen=True)
class JointInfo(Handle):
    """One joint as it was when asked for. Accepted wherever a `Joint` is.

    Attributes:
        joint: Its handle.
        entity_a: Id of one side; 0 is the world.
        entity_b: Id of the other side; 0 is the world.
        kind: What it is.
        frame_in_a: Position and orientation of the joint frame in a.
        frame_in_b: Position and orientation of the joint frame in b.
        collide_connected: Whether both may touch.
        break_force: N; None is never.
        break_torque: N*m; None is never.
        positions: Six numbers, along x y z and about x y z; see `Frame.joint_positions`.
        rates: Of these, m/s and rad/s.
        force: On b, N, world coordinates, mean over the last step.
        torque: On b about the origin of frame b, N*m, likewise.
    """

    joint: Joint
    entity_a: int
    entity_b: int
    kind: Kind | UnknownKind
    frame_in_a: tuple[tuple[float, float, float], tuple[float, float, float, float]]
    frame_in_b: tuple[tuple[float, float, float], tuple[float, float, float, float]]
    collide_connected: bool
    break_force: float | None
    break_torque: float | None
    positions: tuple[float, ...]
    rates: tuple[float, ...]
    force: tuple[float, float, float]
    torque: tuple[float, float, float]

    @property
    def id(self) -> int:
        """The id of the joint."""
        return self.joint.id

    @property
    def _home(self) -> str:
        return self.joint._home

    def __index__(self) -> int:
        return self.id


def joint_id(joint: Any, home: str) -> int:
    """Returns the id of a Joint, a JointInfo or a number; raises TypeError for any other handle."""
    return _arguments.handle_id(joint, (Joint, JointInfo), "a Joint", home)


def joint_column(joints: Any, what: str, home: str) -> bytes:
    """Returns ids of joints as a byte column; an array of numbers takes the fast way."""
    return _arguments.id_column(joints, what, home, joint_id)


def _limits(angular: bool, lower: float | None, upper: float | None) -> Any:
    if lower is None and upper is None:
        return None
    if angular:
        return make.AngleLimits(lower_radians=lower, upper_radians=upper)
    return make.DistanceLimits(lower_metres=lower, upper_metres=upper)


def _motor(angular: bool, motor: Motor | None) -> Any:
    if motor is None:
        return None
    instance(motor, Motor, "motor", "joints.Motor")
    drive = {"target_velocity": motor.velocity, "stiffness": motor.stiffness, "damping": motor.damping}
    if angular:
        return make.AngularMotor(torque_max=motor.force_max, target_radians=motor.position, **drive)
    return make.LinearMotor(force_max=motor.force_max, target_metres=motor.position, **drive)


def _spring(angular: bool, spring: Spring | None) -> Any:
    if spring is None:
        return None
    instance(spring, Spring, "spring", "joints.Spring")
    if angular:
        return make.AngularSpring(stiffness=spring.stiffness, damping=spring.damping, rest_radians=spring.rest)
    return make.LinearSpring(stiffness=spring.stiffness, damping=spring.damping, rest_metres=spring.rest)


def _parts(angular: bool, axis: Axis) -> dict[str, Any]:
    instance(axis, Axis, "axis", "joints.Axis")
    return {
        "limits": _limits(angular, axis.lower, axis.upper),
        "motor": _motor(angular, axis.motor),
        "spring": _spring(angular, axis.spring),
    }


def _angular(axis: Axis | None) -> Any:
    return None if axis is None else make.AngularAxis(**_parts(True, axis))


def _linear(axis: Axis | None) -> Any:
    return None if axis is None else make.LinearAxis(**_parts(False, axis))


def encode(kind: Kind) -> dict[str, Any]:
    """Returns the field of a Joint message that says `kind`; raises TypeError for what is none."""
    if isinstance(kind, Ball):
        twist = _limits(True, kind.twist_lower, kind.twist_upper)
        return {"ball": make.BallJoint(swing_max_radians=kind.swing_max, twist=twist)}
    if isinstance(kind, Hinge):
        return {"hinge": make.HingeJoint(**_parts(True, kind))}
    if isinstance(kind, Slider):
        return {"slider": make.SliderJoint(**_parts(False, kind))}
    if isinstance(kind, Distance):
        return {"distance": make.DistanceJoint(**_parts(False, kind))}
    if isinstance(kind, Universal):
        return {"universal": make.UniversalJoint(about_x=_angular(kind.about_x), about_y=_angular(kind.about_y))}
    if isinstance(kind, Fixed):
        return {"fixed": make.FixedJoint()}
    if isinstance(kind, Wheel):
        suspension, steering, spin = _linear(kind.suspension), _angular(kind.steering), _angular(kind.spin)
        return {"wheel": make.WheelJoint(suspension=suspension, steering=steering, spin=spin)}
    if isinstance(kind, SixDof):
        along = {name: _linear(getattr(kind, name)) for name in ("along_x", "along_y", "along_z")}
        about = {name: _angular(getattr(kind, name)) for name in ("about_x", "about_y", "about_z")}
        return {"six_dof": make.SixDofJoint(**along, **about)}
    if isinstance(kind, Gear):
        return {"gear": make.GearJoint(ratio=kind.ratio)}
    kinds = ", ".join(f"genphys.joints.{each.__name__}(...)" for each in typing.get_args(Kind))
    raise TypeError(f"kind is {reprlib.repr(kind)}, not one of: {kinds}")


def _optional(message: Any, *names: str) -> Any:
    """The value of the first of these fields that the message knows; None when it is unset."""
    for name in names:
        if name in message.DESCRIPTOR.fields_by_name:
            return getattr(message, name) if message.HasField(name) else None
    return None


def _decode_parts(message: Any) -> dict[str, Any]:
    parts: dict[str, Any] = {
        "lower": _optional(message.limits, "lower_radians", "lower_metres"),
        "upper": _optional(message.limits, "upper_radians", "upper_metres"),
    }
    if message.HasField("motor"):
        motor = message.motor
        parts["motor"] = Motor(
            velocity=motor.target_velocity,
            position=_optional(motor, "target_radians", "target_metres"),
            stiffness=motor.stiffness,
            damping=motor.damping,
            force_max=_optional(motor, "torque_max", "force_max"),
        )
    if message.HasField("spring"):
        spring = message.spring
        rest = spring.rest_radians if "rest_radians" in spring.DESCRIPTOR.fields_by_name else spring.rest_metres
        parts["spring"] = Spring(stiffness=spring.stiffness, damping=spring.damping, rest=rest)
    return parts


def _decode_axes(message: Any) -> dict[str, Axis]:
    return {field.name: Axis(**_decode_parts(axis)) for field, axis in message.ListFields()}


def decode(message: Any) -> Kind | UnknownKind:
    """Returns the kind of a Joint message."""
    name = message.WhichOneof("kind") or ""
    axial = {"hinge": Hinge, "slider": Slider, "distance": Distance}
    compound = {"universal": Universal, "wheel": Wheel, "six_dof": SixDof}
    if name in axial:
        return axial[name](**_decode_parts(getattr(message, name)))
    if name in compound:
        return compound[name](**_decode_axes(getattr(message, name)))
    if name == "ball":
        ball = message.ball
        return Ball(
            swing_max=_optional(ball, "swing_max_radians"),
            twist_lower=_optional(ball.twist, "lower_radians"),
            twist_upper=_optional(ball.twist, "upper_radians"),
        )
    if name == "fixed":
        return Fixed()
    if name == "gear":
        return Gear(ratio=message.gear.ratio if message.gear.HasField("ratio") else 1.0)
    return UnknownKind(name)

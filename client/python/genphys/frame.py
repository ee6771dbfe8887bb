"""What a world looked like after one step: columns as numpy arrays that share the bytes of the message."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _encode
from ._contract import SCALAR, wire
from .model import Entity, Stamp

if TYPE_CHECKING:
    from .events import Event, Gap

_DTYPES: dict[int, np.dtype[Any]] = {
    0: np.dtype("<f8"),
    SCALAR.number("float64"): np.dtype("<f8"),
    SCALAR.number("float32"): np.dtype("<f4"),
}
_ID = np.dtype("<u8")
_ASKED_BY = {
    "positions": "poses",
    "orientations": "poses",
    "linear_velocities": "velocities",
    "angular_velocities": "velocities",
    "net_forces": "net_forces",
    "joint_positions": "joints",
    "joint_rates": "joints",
    "joint_forces": "joints",
}

FloatColumn = NDArray[np.floating[Any]]


def stamp_of(message: Any) -> Stamp:
    """Returns the Stamp of a WorldStamp message."""
    return Stamp(
        step=message.step,
        time=message.simulation_time_seconds,
        epoch=message.epoch,
        state_hash=message.state_hash if message.HasField("state_hash") else None,
    )


class Rows:
    """Which entity is in which row: shared by all frames with the same set of rows."""

    __slots__ = ("ids", "key", "_index")

    def __init__(self, key: tuple[int, int], column: bytes) -> None:
        self.key = key
        self.ids: NDArray[np.uint64] = np.frombuffer(column, _ID)
        self._index: dict[int, int] | None = None

    def find(self, entity: object) -> int:
        """Returns the row of an entity; raises KeyError if it has none."""
        if self._index is None:
            # Built at the first question and kept: most frames are never asked, and their rows rarely change.
            self._index = {each: row for row, each in enumerate(self.ids.tolist())}
        number = _encode.entity_id(entity, "")
        try:
            return self._index[number]
        except KeyError:
            raise KeyError(f"entity {number} is not in this frame") from None


class RowsCache:
    """Remembers the last set of rows of one source of frames, which is not sent again while it is the same."""

    def __init__(self) -> None:
        self._last: Rows | None = None

    def rows_of(self, message: Any) -> Rows:
        """Returns the rows of a Frame message."""
        key = (message.stamp.epoch, message.rows_id)
        last = self._last
        if last is not None and last.key == key:
            return last
        rows = Rows(key, message.entity_ids)
        # A reply without a frame has no rows_id, and must not push out what the next one needs.
        if message.rows_id != 0 and not message.HasField("keyframe_step"):
            self._last = rows
        return rows


class Frame:
    """One state of a world. Row i of every column is the entity `ids[i]`; find a row with `row(entity)`.

    The columns are read-only views of the received bytes. Asking for one that was not requested raises
    AttributeError. A frame can be pickled and copied, as for other processes.
    """

    __slots__ = ("_message", "_rows", "_stamp", "_columns", "_dtype", "_wanted")

    def __init__(self, message: Any, rows: Rows | None = None, stamp: Any = None, wanted: Any = None) -> None:
        self._message = message
        # The FrameRequest that it answers; None when that is not known, and then its columns must tell.
        self._wanted = wanted
        self._rows = rows or Rows((0, 0), message.entity_ids)
        self._stamp = message.stamp if stamp is None else stamp
        self._columns: dict[str, FloatColumn] = {}
        self._dtype: np.dtype[Any] | None = None

    @property
    def stamp(self) -> Stamp:
        """When this was true."""
        return stamp_of(self._stamp)

    @property
    def step(self) -> int:
        """After which step of the world."""
        return int(self._stamp.step)

    @property
    def time(self) -> float:
        """Simulated seconds since the beginning of the epoch."""
        return float(self._stamp.simulation_time_seconds)

    @property
    def epoch(self) -> int:
        """Changes when the world is reset."""
        return int(self._stamp.epoch)

    @property
    def state_hash(self) -> int | None:
        """Hash of the whole physical state, if the world records it."""
        return self.stamp.state_hash

    @property
    def ids(self) -> NDArray[np.uint64]:
        """(n,): the entity of each row."""
        return self._rows.ids

    @property
    def positions(self) -> FloatColumn:
        """(n, 3): of the entity's frame, metres, world coordinates."""
        return self._column("positions", 3)

    @property
    def orientations(self) -> FloatColumn:
        """(n, 4): unit quaternions w x y z, entity to world."""
        return self._column("orientations", 4)

    @property
    def linear_velocities(self) -> FloatColumn:
        """(n, 3): of the centre of mass, m/s, world coordinates."""
        return self._column("linear_velocities", 3)

    @property
    def angular_velocities(self) -> FloatColumn:
        """(n, 3): rad/s, world coordinates."""
        return self._column("angular_velocities", 3)

    @property
    def net_forces(self) -> FloatColumn:
        """(n, 6): force in N and torque in N*m that acted in the last step, world coordinates."""
        return self._column("net_forces", 6)

    @property
    def joint_ids(self) -> NDArray[np.uint64]:
        """(m,): the joints of the columns below, ascending; empty unless they were asked for."""
        return np.frombuffer(self._message.joint_ids, "<u8")

    @property
    def joint_positions(self) -> FloatColumn:
        """(m, 6): along x y z in metres and about x y z in radians of the joint frame, full turns counted.

        A hinge has the last, a slider the third, a universal joint the fourth and fifth, a wheel the third, the sixth
        (steering) and the fifth (spin), a ball the fourth (swing) and the sixth (twist), a distance the first.
        """
        return self._joint_column("joint_positions")

    @property
    def joint_rates(self) -> FloatColumn:
        """(m, 6): rates of the positions, m/s and rad/s."""
        return self._joint_column("joint_rates")

    @property
    def joint_forces(self) -> FloatColumn:
        """(m, 6): force in N and torque in N*m on entity b, mean over the last step, world coordinates."""
        return self._joint_column("joint_forces")

    @property
    def asleep(self) -> NDArray[np.bool_]:
        """(n,): whether it sleeps. A copy: it travels as bits."""
        if self._wanted is not None and not self._wanted.ListFields():
            raise AttributeError("no frame was asked for: see FrameRequest")
        bits = np.frombuffer(self._message.asleep, np.uint8)
        if bits.size == 0:
            return np.zeros(len(self), bool)
        return np.unpackbits(bits, count=len(self), bitorder="little").astype(bool)

    @property
    def keyframe_id(self) -> int:
        """Names the keyframe that this is or was told against; 0 unless deltas were asked for."""
        return int(self._message.keyframe_id)

    @property
    def skipped_frames(self) -> int:
        """Of `World.frames`: how many frames this listener was too slow to receive since the last one."""
        return int(self._message.skipped_frames)

    def row(self, entity: object) -> int:
        """Returns the row of an `Entity` or id; raises KeyError if it is not in this frame."""
        return self._rows.find(entity)

    def __len__(self) -> int:
        return len(self._rows.ids)

    def __reduce__(self) -> tuple[Any, ...]:
        # The classes of messages are made at run time, and no other process finds them by name: their bytes go.
        return _restored, (
            type(self),
            self._message.SerializeToString(),
            (self._rows.key, self._rows.ids.tobytes()),
            self._stamp.SerializeToString(),
            None if self._wanted is None else self._wanted.SerializeToString(),
            {name: getattr(self, name) for name in type(self).__slots__ if type(self) is not Frame},
        )

    def __repr__(self) -> str:
        return f"<{type(self).__name__} step {self.step}, {self.time:.6g} s, {len(self)} entities>"

    def _check_asked(self, name: str) -> None:
        # Rows alone do not tell: where there are none, what was not asked for looks like what was.
        if self._wanted is not None and not getattr(self._wanted, _ASKED_BY[name]):
            raise AttributeError(f"{name} were not asked for: see FrameRequest")

    def _joint_column(self, name: str) -> FloatColumn:
        self._check_asked(name)
        return np.frombuffer(getattr(self._message, name), _DTYPES[self._message.scalar]).reshape(-1, 6)

    def _column(self, name: str, width: int) -> FloatColumn:
        # Kept, because protobuf copies a bytes field each time that it is read.
        column = self._columns.get(name)
        if column is None:
            if self._dtype is None:
                self._dtype = _DTYPES[self._message.scalar]
            column = np.frombuffer(getattr(self._message, name), self._dtype).reshape(-1, width)
            rows = len(self._rows.ids)
            if rows == 0:
                self._check_asked(name)
            if len(column) != rows:
                raise AttributeError(f"{name} were not asked for: see FrameRequest")
            self._columns[name] = column
        return column


def _restored(
    kind: type[Frame], message: bytes, rows: Any, stamp: bytes, wanted: bytes | None, more: dict[str, Any]
) -> Frame:
    """Returns a frame that was copied or stored."""
    frame = kind.__new__(kind)
    request = None if wanted is None else wire.FrameRequest.FromString(wanted)
    whole = wire.Frame.FromString(message)
    Frame.__init__(frame, whole, Rows(*rows), wire.WorldStamp.FromString(stamp), request)
    for name, value in more.items():
        setattr(frame, name, value)
    return frame


@dataclasses.dataclass(frozen=True)
class StepStats:
    """Where the last step's time went.

    Attributes:
        entities_asleep: Resting, left out.
        entities_in_flight: Integrated exactly, without the engine.
        entities_in_engine: Stepped by the engine.
        pairs_tested: Pairs of geometries that were looked at closely.
        contacts: Contact points found.
        islands: Groups, among those stepped by the engine, of entities that touch or are joined.
        stages: Nanoseconds of each part of the step, by name, in order of time.
    """

    entities_asleep: int
    entities_in_flight: int
    entities_in_engine: int
    pairs_tested: int
    contacts: int
    islands: int
    stages: dict[str, int]

    def __str__(self) -> str:
        total = sum(self.stages.values())
        width = max(map(len, (*self.stages, "step")))
        times = [
            f"{name:<{width}}{nanoseconds / 1000:12.1f} us {100 * nanoseconds / total if total else 0:5.1f} %"
            for name, nanoseconds in (*self.stages.items(), ("step", total))
        ]
        return "\n".join(
            [
                f"entities: {self.entities_asleep} asleep, {self.entities_in_flight} in flight, "
                f"{self.entities_in_engine} in the engine",
                f"touching: {self.pairs_tested} pairs, {self.contacts} contacts, {self.islands} islands",
                *times,
            ]
        )


class StepResult(Frame):
    """What came of `World.step`: the frame after the last step, and what happened on the way.

    Attributes:
        events: Of the commands and of all steps, in order; empty if none were asked for.
        events_left_out: Which of them had no room in the reply, as of thousands of steps; None: all are there. Then a
            warning says so, too: ask for fewer steps or kinds at once, or listen by `World.events`.
        created: Entities that the commands of a batch created, in order.
        stats: Of the last of these steps; None if they were not asked for, or if there was no step.
    """

    __slots__ = ("events", "events_left_out", "created", "stats")

    def __init__(
        self,
        response: Any,
        rows: Rows,
        events: tuple[Event, ...],
        created: tuple[Entity, ...],
        stats: StepStats | None,
        message: Any = None,
        events_left_out: Gap | None = None,
        wanted: Any = None,
    ) -> None:
        # Without a frame the reply is stamped all the same.
        super().__init__(response.frame if message is None else message, rows, response.stamp, wanted)
        self.events = events
        self.events_left_out = events_left_out
        self.created = created
        self.stats = stats


def stats_of(message: Any) -> StepStats:
    """Returns the StepStats of a message."""
    return StepStats(
        entities_asleep=message.entities_asleep,
        entities_in_flight=message.entities_in_flight,
        entities_in_engine=message.entities_in_engine,
        pairs_tested=message.pairs_tested,
        contacts=message.contacts,
        islands=message.islands,
        stages={stage.stage: stage.nanoseconds for stage in message.stages},
    )


_MERGED = ("positions", "orientations", "linear_velocities", "angular_velocities", "net_forces")


class DeltaMerger:
    """Turns keyframes and deltas of one source of frames into whole frames."""

    def __init__(self) -> None:
        self.keyframe: Frame | None = None
        """The last one that came."""

    def merge(self, frame: Frame, message: Any) -> Frame | None:
        """Returns the whole frame, or None for a delta against a keyframe that never came."""
        base = self.base_of(frame, message)
        return None if base is None else whole(frame, message, base)

    def base_of(self, frame: Frame, message: Any) -> Frame | None:
        """Returns what `whole` needs beside the frame, so that only frames that somebody sees are laid over others."""
        if not message.HasField("keyframe_step"):
            self.keyframe = frame
            return frame
        base = self.keyframe
        return base if base is not None and base.keyframe_id == message.keyframe_id else None


def whole(frame: Frame, message: Any, base: Frame) -> Frame:
    """Returns `frame`, whose message is given, laid over `base` if it is a delta."""
    return frame if base is frame else Frame(lay_over(base, message), base._rows, wanted=frame._wanted)


def lay_over(base: Frame, delta: Any) -> Any:
    """Returns the message of the whole frame that `delta` tells against the keyframe `base`."""
    rows = np.searchsorted(base.ids, np.frombuffer(delta.entity_ids, _ID))
    whole = type(delta)()
    whole.CopyFrom(delta)
    whole.ClearField("keyframe_step")
    for name in _MERGED:
        if getattr(base._message, name):
            column = getattr(base, name).copy()
            column[rows] = np.frombuffer(getattr(delta, name), column.dtype).reshape(-1, column.shape[1])
            setattr(whole, name, column.tobytes())
    asleep = base.asleep
    asleep[rows] = np.unpackbits(np.frombuffer(delta.asleep, np.uint8), count=len(rows), bitorder="little")
    whole.asleep = np.packbits(asleep, bitorder="little").tobytes()
    return whole

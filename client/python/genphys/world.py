"""One world on a server."""

from __future__ import annotations

import contextlib
import dataclasses
import operator
import warnings
import weakref
from collections.abc import Callable, Iterator
from types import TracebackType
from typing import Any

from . import _arguments, _decode, _encode, _naming, model
from ._closing import Closing
from ._connection import Connection
from ._contract import make, wire
from .batch import Batch
from .commands import Commands
from .drive import Drive
from .errors import DivergedError, EventsLeftOutWarning, GenphysError, WorldNotFoundError, created_ids
from .events import EntityCreated, EntityUpdated, Event, Gap, decode
from .fields import ForceField, ForceFieldInfo
from .fields import decode as decode_field
from .frame import Frame, Rows, RowsCache, StepResult, lay_over, stamp_of, stats_of
from .joints import Joint, JointInfo
from .model import Entity, EntityInfo, Stamp, WorldInfo
from .queries import Queries
from .streams import EventStream, Position, Stream
from .viewing import FrameStream

_PAGE_SIZE = 1000
_KEYFRAMES_MAX = 16


@dataclasses.dataclass(frozen=True)
class PreparedStep:
    """A StepRequest with the commands collected for it, and how its response is read."""

    world: World
    pending: Batch
    request: Any
    keyframe: Frame | None

    def result(self, response: Any) -> StepResult:
        """Returns what the response says, and gives what the commands created their ids."""
        world = self.world
        created = self._settle(lambda index: response.results[index].created_id)
        rows, whole = self._whole(response.frame)
        events = response.events.events
        return StepResult(
            response,
            rows,
            tuple(map(world._event, events)) if events else (),
            created,
            stats_of(response.stats) if response.HasField("stats") else None,
            whole,
            _events_left_out(response),
            self.request.frame,
        )

    def refused(self, error: GenphysError) -> GenphysError:
        """Gives what the commands of a step that ended early created their ids, and returns the error."""
        self._settle(created_ids(error).get)
        error.argument = _naming.of_batch(error.argument, self.pending.verbs)
        return error

    def _settle(self, id_of: Callable[[int], int | None]) -> tuple[Entity, ...]:
        created = self.pending._settle(id_of)
        for entity in created:
            self.world._names[entity.id] = entity.name
        return created

    def _whole(self, message: Any) -> tuple[Rows, Any]:
        if not message.HasField("keyframe_step"):
            rows = self.world._rows.rows_of(message)
            if message.keyframe_id:
                self.world._keep_keyframe(self.request.frame, Frame(message, rows))
            return rows, message
        if self.keyframe is None or self.keyframe.keyframe_id != message.keyframe_id:
            raise GenphysError("the server sent a delta against a keyframe that it did not send")
        return self.keyframe._rows, lay_over(self.keyframe, message)


def _position(after: Any) -> Position:
    if isinstance(after, (tuple, list)) and len(after) == 2:
        with contextlib.suppress(TypeError):
            return Position(*map(operator.index, after))
    raise TypeError(f"after is {after!r}, not a position (epoch, sequence), as EventStream.position has it")


def _events_left_out(response: Any) -> Gap | None:
    if not response.HasField("events_left_out"):
        return None
    gap = Gap(response.events_left_out.first_sequence, response.events_left_out.last_sequence)
    warnings.warn(
        f"the result has no room for the events {gap.first_sequence} to {gap.last_sequence}: take fewer steps at once, "
        "ask for fewer kinds, or listen by World.events",
        EventsLeftOutWarning,
        stacklevel=4,  # whoever asked for the step
    )
    return gap


class World(Closing, Commands, Queries):
    """One world. Made by `Server.create_world` and `Server.world`.

    A world that was created here is deleted at the end of its `with` block; one that was joined is left alone.
    Every method takes `timeout` in seconds; None is the default of the connection. Calls may come from several
    threads, but the commands of a batch go with the step of whoever steps next.
    """

    def __init__(self, connection: Connection, name: str, owned: bool) -> None:
        self._connection = connection
        self._name = self._home = name
        self._owned = owned
        self._names: dict[int, str] = {}
        self._pending = Batch(self._name)
        self._rows = RowsCache()
        self._keyframes: dict[bytes, Frame] = {}
        self._streams: weakref.WeakSet[Stream[Any] | FrameStream | Drive] = weakref.WeakSet()
        # Requests of the usual kinds are made once: copying one is cheaper than filling it.
        self._frame_requests = {True: _encode.frame_request(True, name), False: None}

    @property
    def name(self) -> str:
        """Its name, as in "lab"."""
        return _decode.short_name(self._name)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
        if not self._owned or self._connection.closed:
            return
        try:
            self.delete()
        except WorldNotFoundError:
            pass  # Somebody else was faster; it is gone, as it should be.
        except GenphysError:
            # A server that is gone must not hide the error that came first.
            if error is None:
                raise

    def __repr__(self) -> str:
        return f"<World {self.name} at {self._connection.address}>"

    def close(self) -> None:
        """Ends the streams that were opened here; the world lives on. May be called again."""
        for stream in list(self._streams):
            stream.close()

    def learn_names(self) -> None:
        """Learns the names of the first entities, for events; `entities` learns all.

        Raises:
            WorldNotFoundError: the world is gone.
        """
        request = wire.ListEntitiesRequest(world=self._name, page_size=_PAGE_SIZE)
        for entity in self._connection.call("ListEntities", request).entities:
            self._names[entity.id] = entity.display_name

    def info(self, *, timeout: float | None = None) -> WorldInfo:
        """Returns its engine, state, gravity, step size and stamp."""
        response = self._connection.call("GetWorld", wire.GetWorldRequest(name=self._name), timeout)
        return _decode.world_info(response.world, response.stamp)

    def entity(self, entity: Entity | int, *, timeout: float | None = None) -> EntityInfo:
        """Returns one entity as it is now.

        Raises:
            StaleIdError: it is gone.
            EntityNotFoundError: there never was one with this id.
        """
        request = wire.GetEntityRequest(world=self._name, entity_id=_encode.entity_id(entity, self._name))
        response = self._connection.call("GetEntity", request, timeout)
        return self._learn(_decode.entity_info(response.entity, self._name))

    def entities(self, *, timeout: float | None = None) -> list[EntityInfo]:
        """Returns all entities as they are now, in order of id."""
        found: list[EntityInfo] = []
        request = wire.ListEntitiesRequest(world=self._name, page_size=_PAGE_SIZE)
        while True:
            response = self._connection.call("ListEntities", request, timeout)
            found += [self._learn(_decode.entity_info(each, self._name)) for each in response.entities]
            if not response.next_page_token:
                return found
            request.page_token = response.next_page_token

    def joints(self, *, timeout: float | None = None) -> list[JointInfo]:
        """Returns all joints and what they do now, in order of id."""
        found: list[JointInfo] = []
        request = wire.ListJointsRequest(world=self._name, page_size=_PAGE_SIZE)
        while True:
            response = self._connection.call("ListJoints", request, timeout)
            found += [_decode.joint_info(*each, self._name) for each in zip(response.joints, response.states)]
            if not response.next_page_token:
                return found
            request.page_token = response.next_page_token

    def fields(self, *, timeout: float | None = None) -> list[ForceFieldInfo]:
        """Returns all force fields, in order of id."""
        found: list[ForceFieldInfo] = []
        request = wire.ListForceFieldsRequest(world=self._name, page_size=_PAGE_SIZE)
        while True:
            response = self._connection.call("ListForceFields", request, timeout)
            found += [decode_field(each, self._name) for each in response.fields]
            if not response.next_page_token:
                return found
            request.page_token = response.next_page_token

    def step(
        self,
        steps: int = 1,
        *,
        frame: bool | model.FrameRequest = True,
        events: bool | model.EventFilter = True,
        stats: bool = False,
        step_size: float | None = None,
        expected_step: int | None = None,
        timeout: float | None = None,
    ) -> StepResult:
        """Applies the collected commands, advances time, and returns what came of it: one round trip.

        Args:
            steps: How many; 0 applies the commands alone.
            frame: Columns of the frame after the last step; False for none.
            events: Which events of all steps to return; False for none.
            stats: Whether to return where the time of the last step went.
            step_size: Seconds of each of these steps; None is the stepper's.
            expected_step: Refuse unless the world is at this step.
            timeout: Seconds of wall-clock time for the call.

        Raises:
            StepMismatchError: the world is not at `expected_step`.
            WorldNotPausedError: the world is playing.
            DeadlineExceededError: it took longer than `timeout`. What was done stays done, and what its commands created
                has ids: `metadata` says how far it came, if the server could tell it in time.
            DivergedError: the state became infinite.
            GenphysError: a collected command was refused: none was applied, and all are dropped.
        """
        request = self._step_request(
            steps, frame=frame, events=events, stats=stats, step_size=step_size, expected_step=expected_step
        )
        self._connection.deadline(timeout)  # raises what is wrong with it while the commands are still collected
        prepared = self._take_along(request)
        try:
            response = self._connection.call("Step", prepared.request, timeout)
        except GenphysError as error:
            prepared.refused(error)
            raise
        return prepared.result(response)

    def drive(self) -> Drive:
        """Opens a stream of steps whose results need not be waited for one by one.

        `with world.drive() as drive: drive.send(); drive.send(); result = drive.receive()`: the second step is taken
        while the result of the first is looked at.
        """
        drive = Drive(self._connection, self)
        self._streams.add(drive)
        return drive

    @contextlib.contextmanager
    def batch(self) -> Iterator[Batch]:
        """Collects commands that go with the next `step`: `with world.batch() as b: b.apply_force(...)`.

        They are applied in order before its first step, or none of them. If the block raises, they are dropped.
        Entities that the batch adds have an id after that step. Commands given to it after its block raise ValueError.
        """
        batch = Batch(self._name)
        try:
            yield batch
        finally:
            batch._end()
        self._pending._append(batch)

    def play(self, real_time_factor: float | None = None, *, timeout: float | None = None) -> Stamp:
        """Lets the world move by itself.

        Args:
            real_time_factor: Simulated seconds per second; None is 1, 0 is as fast as possible.
            timeout: Seconds.
        """
        request = make.PlayWorldRequest(name=self._name, real_time_factor=real_time_factor)
        return stamp_of(self._connection.call("PlayWorld", request, timeout).stamp)

    def pause(self, *, timeout: float | None = None) -> Stamp:
        """Stops the world between two steps."""
        request = wire.PauseWorldRequest(name=self._name)
        return stamp_of(self._connection.call("PauseWorld", request, timeout).stamp)

    def reset(self, *, timeout: float | None = None) -> Stamp:
        """Takes the world back to where its first step began, with what had been made by then, in a new epoch.

        Forces are not brought back, nor is what came along with that first step (in a batch): an episode tells them again.
        What was collected for the next step and not sent yet is dropped.
        What is changed by calls of their own between a reset and the next step is of the beginning to which the next
        reset goes back: what shall be otherwise in each episode alone goes along with its first step.

        Ids go back with it, so that who does the same again finds the same ids: those of entities, joints and force
        fields that were made after the first step are given to whatever is made next. A handle of one of these, kept over
        a reset, names that then.
        """
        request = wire.ResetWorldRequest(name=self._name)
        try:
            stamp = stamp_of(self._connection.call("ResetWorld", request, timeout).stamp)
        except DivergedError:
            # It was reset all the same, and is without an engine: no handle of before fits it.
            self._pending = Batch(self._name)
            raise
        self._pending = Batch(self._name)
        return stamp

    def delete(self, *, timeout: float | None = None) -> None:
        """Ends the world on the server.

        Raises:
            WorldNotFoundError: somebody else did.
        """
        self.close()
        self._owned = False
        self._connection.call("DeleteWorld", wire.DeleteWorldRequest(name=self._name), timeout)

    def events(
        self,
        filter: model.EventFilter | None = None,
        *,
        after: Position | tuple[int, int] | None = None,
        duration: float | None = None,
    ) -> EventStream:
        """Returns an iterator over events as they happen; it misses nothing after it is returned.

        It ends when the world is deleted. A lost connection is taken up again where it broke. `Gap` says which events
        are lost because this listener was too slow, `EpochBegan` that the world was reset.

        Args:
            filter: Which events; None is all that the world records.
            after: The `position` of an earlier stream, to go on from there; None is from now on. What the server no
                longer keeps of it comes as a `Gap`.
            duration: Seconds of wall-clock time after which the iteration ends; None is never.
        """
        start = None if after is None else _position(after)
        wanted = _encode.event_filter(filter, self._name, "filter")
        stream = EventStream(self._connection, self._name, wanted, start, duration, self._event)
        self._streams.add(stream)
        return stream

    def frames(
        self,
        frame: bool | model.FrameRequest = True,
        *,
        every: int | None = None,
        duration: float | None = None,
    ) -> FrameStream:
        """Returns an iterator over frames as they happen, whoever steps the world; the first comes at once.

        A listener always gets the newest frame, and `skipped_frames` counts those that it missed; the world never
        waits for it. While it looks at one, a thread reads those that come in its place.

        Args:
            frame: Which columns.
            every: Only steps whose number is a multiple of this.
            duration: Seconds of wall-clock time after which the iteration ends; None is never.
        """
        wanted = _encode.frame_request(frame, self._name)
        stream = FrameStream(self._connection, self._name, wanted, every, duration)
        self._streams.add(stream)
        return stream

    def _step_request(
        self,
        steps: int,
        *,
        frame: bool | model.FrameRequest,
        events: bool | model.EventFilter,
        stats: bool,
        step_size: float | None,
        expected_step: int | None,
    ) -> Any:
        """Returns a StepRequest without commands: what is wrong with it must not cost those that are collected."""
        return make.StepRequest(
            world=self._name,
            steps=steps,
            step_size_seconds=step_size,
            frame=self._frame_requests[frame]
            if isinstance(frame, bool)
            else _encode.frame_request(frame, self._name),
            events=_encode.event_filter(events, self._name),
            stats=stats,
            expected_step=expected_step,
        )

    def _take_along(self, request: Any) -> PreparedStep:
        """Lets the collected commands go with a StepRequest."""
        pending, self._pending = self._pending, Batch(self._name)
        request.commands.extend(pending.commands)
        keyframe = None
        if request.frame.deltas:
            keyframe = self._keyframes.get(request.frame.SerializeToString())
        if keyframe is not None:
            request.frame.keyframe_id = keyframe.keyframe_id
        return PreparedStep(self, pending, request, keyframe)

    def _keep_keyframe(self, wishes: Any, frame: Frame) -> None:
        key = type(wishes)()
        key.CopyFrom(wishes)
        key.ClearField("keyframe_id")
        if len(self._keyframes) >= _KEYFRAMES_MAX:
            self._keyframes.clear()
        self._keyframes[key.SerializeToString()] = frame

    def _create(self, entity: Any, verb: str = "") -> Entity:
        request = wire.CreateEntityRequest(world=self._name, entity=entity)
        try:
            response = self._connection.call("CreateEntity", request)
        except GenphysError as error:
            if verb:
                error.argument = _naming.of_shape(error.argument)
            raise
        return self._learn(_decode.entity_info(response.entity, self._name)).entity

    def _create_field(self, command: Any) -> ForceField:
        response = self._send(wire.Command(create_force_field=command))
        return ForceField(response.results[0].created_id, self._name)

    def _submit(self, *commands: Any) -> None:
        self._send(*commands)

    def _join(self, joint: Any) -> Joint:
        response = self._send(wire.Command(create_joint=wire.CreateJoint(joint=joint)))
        return Joint(response.results[0].created_id, self._name)

    def _send(self, *commands: Any) -> Any:
        try:
            return self._connection.call("Step", wire.StepRequest(world=self._name, commands=commands, steps=0))
        except GenphysError as error:
            error.argument = _naming.of_call(error.argument)
            raise

    def _learn(self, info: EntityInfo) -> EntityInfo:
        self._names[info.id] = info.name
        return info

    def _event(self, message: Any) -> Event:
        event = decode(message, self._entity)
        if isinstance(event, (EntityCreated, EntityUpdated)):
            self._names[event.entity.id] = event.entity.name
        return event

    def _entity(self, number: int) -> Entity:
        return Entity(number, self._names.get(number, ""), self._name)

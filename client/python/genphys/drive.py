"""Steps whose results are not waited for one by one."""

from __future__ import annotations

import collections
import queue
from typing import TYPE_CHECKING, Any

import grpc

from . import errors, model
from ._closing import Closing
from ._connection import Connection
from ._contract import wire
from .frame import StepResult

if TYPE_CHECKING:
    from .world import PreparedStep, World

IN_FLIGHT_MAX = 16
"""Steps that may be sent before the result of the first is received."""


class Drive(Closing):
    """A stream of steps of one world: it steps while this program works. Made by `World.drive`; one thread uses it.

    Results come in the order of sending. What was sent and not received when the stream ends may be done or not. Other
    calls to the world take their own way: one that is to come after a request is made after its result.
    """

    def __init__(self, connection: Connection, world: World) -> None:
        self._world = world
        self._in_flight: collections.deque[PreparedStep] = collections.deque()
        self._requests: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._closed = False
        self._call = connection.stream("Drive", iter(self._requests.get, None))
        connection.keep(self)

    def __del__(self) -> None:
        if hasattr(self, "_call"):
            self.close()

    @property
    def in_flight(self) -> int:
        """How many were sent whose results were not received."""
        return len(self._in_flight)

    def send(
        self,
        steps: int = 1,
        *,
        frame: bool | model.FrameRequest = True,
        events: bool | model.EventFilter = True,
        stats: bool = False,
        step_size: float | None = None,
        expected_step: int | None = None,
    ) -> None:
        """Asks for what `World.step` asks for, with the commands collected so far, and returns at once.

        Raises:
            ValueError: `IN_FLIGHT_MAX` are in flight, or it was closed.
        """
        if self._closed:
            # What it would take along would be lost.
            raise ValueError("this drive is closed: open another one with world.drive()")
        if len(self._in_flight) >= IN_FLIGHT_MAX:
            raise ValueError(f"{IN_FLIGHT_MAX} steps are in flight: receive one first")
        request = self._world._step_request(
            steps, frame=frame, events=events, stats=stats, step_size=step_size, expected_step=expected_step
        )
        prepared = self._world._take_along(request)
        self._in_flight.append(prepared)
        self._requests.put(wire.DriveRequest(step=prepared.request))

    def receive(self) -> StepResult:
        """Waits for the result of the oldest step in flight.

        Raises:
            GenphysError: it was refused. Those sent after it are done all the same, unless they say `expected_step`.
            UnavailableError: the connection is lost, and with it what was in flight.
            ValueError: nothing is in flight.
        """
        if not self._in_flight:
            raise ValueError("nothing is in flight: send first")
        try:
            response = next(self._call)
        except grpc.RpcError as error:
            self._in_flight.clear()
            raise errors.from_rpc_error(error, ended_here=self._closed, request=wire.DriveRequest) from None
        except StopIteration:
            self._in_flight.clear()
            raise errors.UnavailableError("the server ended the stream", code=grpc.StatusCode.UNAVAILABLE) from None
        prepared = self._in_flight.popleft()
        if response.HasField("refusal"):
            raise prepared.refused(errors.from_refusal(response.refusal))
        return prepared.result(response.response)

    def close(self) -> None:
        """Ends the stream; may be called again."""
        self._closed = True
        self._requests.put(None)
        self._call.cancel()

"""What a server pushes, as iterators that survive a lost connection. Those of frames are in `viewing.py`."""

from __future__ import annotations

import collections
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any, Generic, NamedTuple, TypeVar, Union

import grpc

from . import _arguments, errors, events
from ._closing import Closing
from ._connection import Connection, finish
from ._contract import METHODS, make

RECONNECT_SECONDS = 30.0
"""How long a stream tries to come back after a lost connection before it raises."""

WORLD_SECONDS = 5.0
"""How long a server that comes back may be without the world: one that was started again has none, until it is made."""

_RETRY_SECONDS_MIN = 0.05
_RETRY_SECONDS_MAX = 2.0

Item = TypeVar("Item")
AnyEvent = Union[events.Event, events.Gap, events.EpochBegan]


class Position(NamedTuple):
    """How far a listener has come: where `World.events(after=...)` goes on."""

    epoch: int
    sequence: int


class Stream(Closing, Generic[Item]):
    """An iterator over what a server pushes. Use it in a `with` or call `close()`.

    One thread iterates; any thread may close.
    """

    _method = ""

    def __init__(self, connection: Connection, duration: float | None) -> None:
        self._connection = connection
        self._ends_at = None if duration is None else time.monotonic() + _arguments.seconds(duration, "duration")
        self._ready: collections.deque[Item] = collections.deque()
        self._closed = False
        self._reading = threading.Lock()
        self._call: Any = None
        connection.keep(self)
        with self._reading:
            self._subscribe()

    def __iter__(self) -> Iterator[Item]:
        return self

    def __next__(self) -> Item:
        while not self._ready:
            self._receive()
        return self._ready.popleft()

    def close(self) -> None:
        """Ends the stream; a thread that waits in it gets StopIteration. May be called again."""
        self._closed = True
        if self._call is None:
            return
        self._call.cancel()
        # A thread that is reading finishes the call itself.
        if self._reading.acquire(blocking=False):
            try:
                finish(self._call)
            finally:
                self._reading.release()

    def __del__(self) -> None:
        if getattr(self, "_call", None) is not None:
            self.close()

    def _request(self) -> Any:
        raise NotImplementedError

    def _take(self, response: Any) -> None:
        raise NotImplementedError

    def _receive(self) -> None:
        """Reads one message, coming back first if the connection is lost."""
        with self._reading:
            self._receive_here()

    def _receive_here(self) -> None:
        """The same for whoever holds `_reading`."""
        if self._closed:
            raise StopIteration
        try:
            self._take(next(self._call))
        except grpc.RpcError as error:
            finish(self._call)
            if self._closed or self._is_over(error):
                raise StopIteration from None
            cause = self._error_of(error)
            if cause.code != grpc.StatusCode.UNAVAILABLE:
                raise cause from None
            self._resubscribe(cause)

    def _subscribe(self) -> None:
        """Starts the call and waits for its first message, so that nothing after this moment is missed."""
        remaining = None if self._ends_at is None else max(self._ends_at - time.monotonic(), 0.0)
        self._call = self._connection.stream(self._method, self._request(), timeout=remaining)
        if self._closed:
            # Closed by another thread, which did not know of this call yet.
            self._call.cancel()
        late = threading.Event()
        watchdog = threading.Timer(self._connection.first_message_timeout(), _cancel_late, (self._call, late))
        watchdog.daemon = True
        watchdog.start()
        try:
            self._take(next(self._call))
        except grpc.RpcError as error:
            finish(self._call)
            if late.is_set():
                code = grpc.StatusCode.DEADLINE_EXCEEDED
                raise errors.DeadlineExceededError(f"{self._method} sent no first message", code=code) from None
            if not self._is_over(error):
                raise self._error_of(error) from None
            self._closed = True
        except StopIteration:
            self._closed = True
        finally:
            watchdog.cancel()

    def _resubscribe(self, cause: errors.GenphysError) -> None:
        give_up_at = time.monotonic() + RECONNECT_SECONDS
        pause = _RETRY_SECONDS_MIN
        while not self._closed:
            time.sleep(pause)
            pause = min(2 * pause, _RETRY_SECONDS_MAX)
            try:
                self._subscribe()
                return
            except errors.WorldNotFoundError:
                # From now on so long at most.
                give_up_at = min(give_up_at, time.monotonic() + WORLD_SECONDS)
                if time.monotonic() >= give_up_at:
                    raise
            except errors.GenphysError as error:
                if error.code != grpc.StatusCode.UNAVAILABLE:
                    raise
                if time.monotonic() > give_up_at:
                    raise error from cause
        raise StopIteration

    def _error_of(self, error: Any) -> errors.GenphysError:
        return errors.from_rpc_error(error, ended_here=self._closed, request=METHODS[self._method].request)

    def _is_over(self, error: Any) -> bool:
        return self._ends_at is not None and error.code() == grpc.StatusCode.DEADLINE_EXCEEDED


def _cancel_late(call: Any, late: threading.Event) -> None:
    late.set()
    call.cancel()


class EventStream(Stream[AnyEvent]):
    """Events of one world in order, each once; see `World.events`."""

    _method = "WatchEvents"

    def __init__(
        self,
        connection: Connection,
        world: str,
        filter: Any,
        after: Position | None,
        duration: float | None,
        decode: Callable[[Any], events.Event],
    ) -> None:
        self._world = world
        self._filter = filter
        self._position = after
        self._decode = decode
        super().__init__(connection, duration)

    @property
    def position(self) -> Position:
        """How far this listener has come; give it to `World.events(after=...)` to go on from here."""
        if self._position is None:
            raise ValueError("the stream ended before it began")
        return self._position

    def _request(self) -> Any:
        epoch, sequence = self._position or (None, None)
        return make.WatchEventsRequest(world=self._world, filter=self._filter, epoch=epoch, after_sequence=sequence)

    def _take(self, response: Any) -> None:
        epoch = response.stamp.epoch
        if self._position is not None and self._position.epoch != epoch:
            self._ready.append(events.EpochBegan(epoch))
            self._position = Position(epoch, 0)
        seen = 0 if self._position is None else self._position.sequence
        if response.HasField("gap"):
            self._ready.append(events.Gap(response.gap.first_sequence, response.gap.last_sequence))
        for message in response.batch.events:
            # After a lost connection the server may repeat what it had sent already.
            if message.sequence == 0 or message.sequence > seen:
                self._ready.append(self._decode(message))
        reached = max(seen, response.batch.last_sequence, response.gap.last_sequence)
        self._position = Position(epoch, reached)

"""Frames that a server pushes, of which a listener always gets the newest."""

from __future__ import annotations

import threading
import time
import weakref
from collections.abc import Callable, Iterator
from typing import Any

from ._closing import Closing
from ._connection import Connection
from ._contract import make
from .frame import DeltaMerger, Frame, RowsCache, whole
from .streams import Stream

# So long a listener may be away, or never wait for a frame, until somebody reads in its place: what comes meanwhile
# lies unread, in order.
_AWAY_SECONDS = 0.02
# A read that takes longer had to wait: everything that came before is read.
_WAITED_SECONDS = 0.0003
# A listener that comes back gives its stand-in so long to read what is left, as when it kept the interpreter busy.
_CATCH_UP_SECONDS = 0.01
_LOOK_SECONDS = 0.0001
# A stand-in pauses between reads. What comes faster is held back by gRPC and replaced by the server.
_PAUSE_SECONDS = 0.0005
_JOIN_SECONDS = 1.0
# A listener that sees so many frames while a stand-in looks away once goes through what lies unread in no time, and
# needs nobody: the rest is held back.
_FAST_VIEWS = 200

_Unseen = tuple[Frame, Any, Frame]  # a frame, its message, and the keyframe that it is laid over


class _Source(Stream[Frame]):
    """Reads frames and keeps the newest.

    The listener's own thread reads while it keeps up, for a frame that another thread hands over costs ten times as
    much. While it is busy a stand-in reads, because what nobody reads piles up in gRPC, before the server notices that
    this listener is slow. Whoever reads holds `_reading`.
    """

    _method = "WatchFrames"

    def __init__(
        self, connection: Connection, world: str, frame: Any, every: int | None, duration: float | None
    ) -> None:
        self._fixed = make.WatchFramesRequest(world=world, frame=frame, every_nth_step=every)
        # Without a request the server sends what it thinks fit.
        self._wanted = frame
        self._rows = RowsCache()
        self._merger = DeltaMerger()
        self._unseen: list[_Unseen] = []  # one at most
        self._came_at = 0.0  # set while the listener is in `view`
        self._caught_up_at = time.monotonic()
        self._views = 0
        self._awaited = False  # the listener waits for its stand-in
        self._arrived = threading.Event()
        self._stands_in = False
        self._read_at = 0.0  # when the stand-in began to read; 0 while it pauses
        self._parked = False  # the stand-in waits until the listener leaves
        self._left = threading.Event()
        self._over = threading.Event()
        self._stand_in: threading.Thread | None = None
        super().__init__(connection, duration)
        self._stand_in = threading.Thread(target=self._run_stand_in, name="genphys frames", daemon=True)
        self._stand_in.start()

    def view(self) -> Frame:
        """Waits for a frame that was not seen, and returns the newest."""
        self._came_at = came_at = time.monotonic()
        try:
            if self._stands_in and self._unseen:
                self._let_catch_up(came_at + _CATCH_UP_SECONDS)
            while not self._unseen or (unseen := self._take_unseen()) is None:
                self._read_or_wait()
        finally:
            now = time.monotonic()
            if now - came_at > _WAITED_SECONDS:
                self._caught_up_at = now
            self._views += 1
            self._came_at = 0.0
            if self._parked:
                self._left.set()
        frame, _, base = unseen
        return frame if base is frame else whole(*unseen)

    def close(self) -> None:
        super().close()
        self._over.set()
        self._left.set()
        self._arrived.set()
        if self._stand_in is not None and self._stand_in is not threading.current_thread():
            # At the end of a program nobody may be inside of gRPC any more.
            self._stand_in.join(_JOIN_SECONDS)

    def _request(self) -> Any:
        return self._fixed

    def _take(self, response: Any) -> None:
        message = response.frame
        frame = Frame(message, self._rows.rows_of(message), wanted=self._wanted)
        base = self._merger.base_of(frame, message)
        if base is None:
            return
        if self._unseen and (missed := self._take_unseen()) is not None:
            message.skipped_frames += missed[1].skipped_frames + 1
        self._unseen.append((frame, message, base))

    def _take_unseen(self) -> _Unseen | None:
        try:
            # Either thread may be the one that has it.
            return self._unseen.pop()
        except IndexError:
            return None

    def _read_or_wait(self) -> None:
        if self._reading.acquire(blocking=False):
            try:
                # The stand-in may have been quicker.
                if not self._unseen:
                    self._receive_here()
            finally:
                self._reading.release()
            return
        self._arrived.clear()
        self._awaited = True
        if self._reading.locked() and not self._unseen:
            self._arrived.wait()
        self._awaited = False

    def _let_catch_up(self, give_up_at: float) -> None:
        while self._stands_in and (now := time.monotonic()) < give_up_at:
            read_at = self._read_at
            if read_at and now - read_at > _WAITED_SECONDS:
                return
            time.sleep(_LOOK_SECONDS)

    def _run_stand_in(self) -> None:
        views = self._views
        while not self._over.wait(_AWAY_SECONDS):
            before, views, came_at = views, self._views, self._came_at
            if came_at and time.monotonic() - came_at > _WAITED_SECONDS:
                self._park_unless(lambda came_at=came_at: self._came_at != came_at)
            elif views - before < _FAST_VIEWS and time.monotonic() - self._caught_up_at > _AWAY_SECONDS:
                with self._reading:
                    works = self._read_until_awaited()
                self._arrived.set()
                if not works:
                    self._park_unless(self._over.is_set)

    def _park_unless(self, has_happened: Callable[[], bool]) -> None:
        """Sleeps until the listener leaves; one who did so before `_parked` was set has not told."""
        self._parked = True
        if not has_happened():
            self._left.wait()
        self._parked = False
        self._left.clear()

    def _read_until_awaited(self) -> bool:
        """False when something went wrong: the listener meets it again when it reads itself."""
        self._stands_in = True
        try:
            while not self._awaited:
                self._read_at = time.monotonic()
                self._receive_here()
                if not self._came_at:
                    self._read_at = 0.0
                    self._over.wait(_PAUSE_SECONDS)
            return True
        except Exception:
            return False
        finally:
            self._stands_in = False


class FrameStream(Closing, Iterator[Frame]):
    """Frames of one world, the newest when this listener is slow; see `World.frames`. Used like an `EventStream`."""

    def __init__(
        self, connection: Connection, world: str, frame: Any, every: int | None, duration: float | None
    ) -> None:
        # A stand-in must not keep alive what nobody listens to any more.
        self._source = _Source(connection, world, frame, every, duration)
        self._view = self._source.view
        self._finalizer = weakref.finalize(self, self._source.close)
        self._finalizer.atexit = False

    def __next__(self) -> Frame:
        return self._view()

    def close(self) -> None:
        """Ends the stream; a thread that waits in it gets StopIteration. May be called again."""
        self._source.close()

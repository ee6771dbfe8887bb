"""Channels, deadlines and the translation of failures: the only module that calls gRPC."""

from __future__ import annotations

import math
import weakref
from typing import Any

import grpc
from grpc.experimental import ChannelOptions

from . import _arguments, errors
from ._contract import METHODS

DEFAULT_TIMEOUT_SECONDS = 30.0
"""Deadline of every call that is not a stream, unless `timeout` says otherwise."""

_KEEPALIVE_MILLISECONDS = 30_000
_KEEPALIVE_TIMEOUT_MILLISECONDS = 10_000

_OPTIONS: list[tuple[str, int]] = [
    # A frame of 50,000 entities is larger than the 4 MiB that gRPC allows unless told.
    ("grpc.max_receive_message_length", -1),
    ("grpc.max_send_message_length", -1),
    # Streams have no deadline: a dead peer is noticed by unanswered pings.
    ("grpc.keepalive_time_ms", _KEEPALIVE_MILLISECONDS),
    ("grpc.keepalive_timeout_ms", _KEEPALIVE_TIMEOUT_MILLISECONDS),
]


class Connection:
    """One server as seen through gRPC. Safe to use from several threads. Keeps `keep_alive` from being collected."""

    def __init__(self, address: str, timeout: float, keep_alive: object = None) -> None:
        self.address = _arguments.text(address, "address", '"127.0.0.1:50051"')
        self._keep_alive = keep_alive
        self.timeout = timeout
        self._channel = grpc.insecure_channel(address, options=_OPTIONS)
        # Streams are read by the caller's own thread: ten times as many messages per second as through gRPC's
        # default, a thread per stream. The option belongs to a channel and does not suit concurrent unary calls.
        self._stream_channel = grpc.insecure_channel(
            address, options=[*_OPTIONS, (ChannelOptions.SingleThreadedUnaryStream, 1)]
        )
        self._streams: weakref.WeakSet[Any] = weakref.WeakSet()
        # Finalizers run in reverse order at exit, so a private server ends after its connections, whose open streams
        # would keep it waiting.
        self._finalizer = weakref.finalize(self, _close, self._streams, (self._channel, self._stream_channel))
        self._calls = {name: self._callable(method) for name, method in METHODS.items()}

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return not self._finalizer.alive

    def call(self, method: str, request: Any, timeout: float | None = None) -> Any:
        """Makes one unary call.

        Args:
            method: Name of the method, as in "Step".
            request: Its request message.
            timeout: Seconds; None is the connection's default, infinity is no deadline.

        Raises:
            GenphysError: the call failed; a subclass says why.
        """
        self._check_open()
        deadline = self.deadline(timeout)
        try:
            return self._calls[method](request, timeout=deadline)
        except grpc.RpcError as error:
            raise errors.from_rpc_error(error, ended_here=self.closed, request=type(request)) from None
        except ValueError as error:
            # gRPC's way of saying that another thread closed the channel.
            raise _closed(self.address) from error

    def stream(self, method: str, request: Any, timeout: float | None = None) -> Any:
        """Starts a stream and returns the gRPC call; None is no deadline. `request` is an iterator if that streams too."""
        self._check_open()
        return self._calls[method](request, timeout=timeout)

    def keep(self, stream: Any) -> None:
        """Closes `stream` with the connection, unless it is gone by then."""
        self._streams.add(stream)

    def first_message_timeout(self) -> float:
        """Returns how long a stream may take to send its first message, in seconds."""
        return self.timeout if math.isfinite(self.timeout) else DEFAULT_TIMEOUT_SECONDS

    def close(self) -> None:
        """Ends all streams and calls and closes the channels; may be called again."""
        self._finalizer()

    def _callable(self, method: Any) -> Any:
        if method.client_streaming:
            make = self._channel.stream_stream
        elif method.server_streaming:
            make = self._stream_channel.unary_stream
        else:
            make = self._channel.unary_unary
        return make(
            method.path,
            request_serializer=method.request.SerializeToString,
            response_deserializer=method.response.FromString,
        )

    def deadline(self, timeout: float | None) -> float | None:
        """Returns the seconds that gRPC is told: None is the connection's default, infinity is no deadline.

        Raises:
            TypeError: `timeout` is no number.
            ValueError: it is NaN.
        """
        seconds = _arguments.seconds(self.timeout if timeout is None else timeout, "timeout")
        return seconds if math.isfinite(seconds) else None

    def _check_open(self) -> None:
        if self.closed:
            raise _closed(self.address)


def finish(call: Any) -> None:
    """Takes what an ended stream still has to tell gRPC; only one thread may read the call.

    A stream that is read by its caller's thread is torn down by it too. grpcio before its own event engine keeps the
    connection open until then, so that a server cannot end in peace, and has no public name for taking what is left.
    """
    state, consume = getattr(call, "_state", None), getattr(call, "_consume_next_event", None)
    if consume is not None:
        while getattr(state, "due", None):
            try:
                consume()
            except KeyError:
                # Ctrl-C in the middle of a read leaves gRPC with an event that it no longer knows.
                return


def _close(streams: weakref.WeakSet[Any], channels: tuple[Any, ...]) -> None:
    for stream in list(streams):
        stream.close()
    for channel in channels:
        channel.close()


def _closed(address: str) -> errors.CancelledError:
    return errors.CancelledError(f"the connection to {address} is closed", code=grpc.StatusCode.CANCELLED)

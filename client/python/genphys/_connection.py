"""Channels, deadlines and the translation of failures: the only module that calls gRPC."""

from __future__ import annotations

import math
from typing import Any

import grpc
from grpc.experimental import ChannelOptions

from . import errors
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
    """One server as seen through gRPC. Safe to use from several threads."""

    def __init__(self, address: str, timeout: float) -> None:
        self.address = address
        self.timeout = timeout
        self.closed = False
        self._channel = grpc.insecure_channel(address, options=_OPTIONS)
        # Streams are read by the caller's own thread: ten times as many messages per second as through gRPC's
        # default, a thread per stream. The option belongs to a channel and does not suit concurrent unary calls.
        self._stream_channel = grpc.insecure_channel(
            address, options=[*_OPTIONS, (ChannelOptions.SingleThreadedUnaryStream, 1)]
        )
        self._calls = {name: self._callable(method) for name, method in METHODS.items()}

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
        try:
            return self._calls[method](request, timeout=self._deadline(timeout))
        except grpc.RpcError as error:
            raise errors.from_rpc_error(error) from None
        except ValueError as error:
            # gRPC's way of saying that another thread closed the channel.
            raise _closed(self.address) from error

    def stream(self, method: str, request: Any, timeout: float | None = None) -> Any:
        """Starts a server stream and returns the gRPC call; None is no deadline."""
        self._check_open()
        return self._calls[method](request, timeout=timeout)

    def first_message_timeout(self) -> float:
        """Returns how long a stream may take to send its first message, in seconds."""
        return self.timeout if math.isfinite(self.timeout) else DEFAULT_TIMEOUT_SECONDS

    def close(self) -> None:
        """Ends all calls and closes the channels; may be called again."""
        if not self.closed:
            self.closed = True
            self._channel.close()
            self._stream_channel.close()

    def _callable(self, method: Any) -> Any:
        channel = self._stream_channel if method.server_streaming else self._channel
        make = channel.unary_stream if method.server_streaming else channel.unary_unary
        return make(
            method.path,
            request_serializer=method.request.SerializeToString,
            response_deserializer=method.response.FromString,
        )

    def _deadline(self, timeout: float | None) -> float | None:
        seconds = self.timeout if timeout is None else timeout
        return seconds if math.isfinite(seconds) else None

    def _check_open(self) -> None:
        if self.closed:
            raise _closed(self.address)


def _closed(address: str) -> errors.CancelledError:
    return errors.CancelledError(f"the connection to {address} is closed", code=grpc.StatusCode.CANCELLED)

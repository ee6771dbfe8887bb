"""What can go wrong: one exception per reason of the server, and a few of the connection."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import grpc

from . import _naming
from ._contract import enum_names, message_class, wire

_DETAILS_KEY = "grpc-status-details-bin"
_CREATED_KEY = "created_ids"


class GenphysError(Exception):
    """The base of everything that a server refuses and of every failure to reach one.

    Attributes:
        message: What was wrong, for people.
        reason: The stable name of the cause, as in "STALE_ID"; empty if the server gave none.
        argument: What to blame, by the names of this package, as in "position[0]"; of a command that was collected in a
            batch as in "commands[3].set_pose.position[0]", by its place among them. Empty if nothing is.
        field: The same as the contract and all other clients name it, as in "commands[3].set_pose.pose.position.x".
        code: The gRPC status code; None if no call was made.
        metadata: Further details by name. Of a step that ended early "steps_done", of this call, and "step", at which
            the world stands: its commands and these steps stay done. If its commands were cut short "commands_done"
            tells how many of them, the first, were carried out.
    """

    default_reason: ClassVar[str] = ""

    def __init__(
        self,
        message: str,
        *,
        reason: str | None = None,
        field: str = "",
        argument: str | None = None,
        code: grpc.StatusCode | None = None,
        metadata: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(message)
        self.message = message
        self.reason = self.default_reason if reason is None else reason
        self.field = field
        self.argument = field if argument is None else argument
        self.code = code
        self.metadata = dict(metadata or {})

    def __str__(self) -> str:
        what = self.reason or (self.code.name if self.code else "")
        where = f" at {self.argument}" if self.argument else ""
        return f"{self.message} [{what}{where}]" if what else self.message


class StaleIdError(GenphysError):
    """The id once named something that is gone."""

    default_reason = "STALE_ID"


class UnsupportedFeatureError(GenphysError):
    """The engine of the world does not have this feature; see `Server.engines`."""

    default_reason = "UNSUPPORTED_FEATURE"


class NotFiniteError(GenphysError):
    """NaN or infinity was sent."""

    default_reason = "NOT_FINITE"


class NotUnitLengthError(GenphysError):
    """A quaternion or normal is zero or not of length 1."""

    default_reason = "NOT_UNIT_LENGTH"


class LimitExceededError(GenphysError):
    """A queue or quota of the server is at its published limit."""

    default_reason = "LIMIT_EXCEEDED"


class HistoryGoneError(GenphysError):
    """The events to resume after are no longer kept. No server says so yet."""

    default_reason = "HISTORY_GONE"


class WorldNotPausedError(GenphysError):
    """The world is playing and this needs it paused."""

    default_reason = "WORLD_NOT_PAUSED"


class DrainingError(GenphysError):
    """The server is shutting down."""

    default_reason = "DRAINING"


class MissingFieldError(GenphysError):
    """Something that must be given is not."""

    default_reason = "MISSING_FIELD"


class OutOfRangeError(GenphysError):
    """A value, a length or a number of elements is outside its declared limits."""

    default_reason = "OUT_OF_RANGE"


class WorldNotFoundError(GenphysError):
    """No world has this name."""

    default_reason = "WORLD_NOT_FOUND"


class AlreadyExistsError(GenphysError):
    """A world has this name already."""

    default_reason = "ALREADY_EXISTS"


class StepMismatchError(GenphysError):
    """The world is not at the expected step."""

    default_reason = "STEP_MISMATCH"


class DivergedError(GenphysError):
    """The step produced a state that is not finite."""

    default_reason = "DIVERGED"


class PoisonedError(GenphysError):
    """Refused because it ended the engine twice. No server says so yet."""

    default_reason = "POISONED"


class BudgetExceededError(GenphysError):
    """A step would take more memory than the world may use: it was undone, and the world goes on."""

    default_reason = "BUDGET_EXCEEDED"


class SnapshotIncompatibleError(GenphysError):
    """The snapshot is of another engine, build or format. No server says so yet."""

    default_reason = "SNAPSHOT_INCOMPATIBLE"


class WorldFaultedError(GenphysError):
    """The world is faulted: it can be read, reset and deleted, nothing else."""

    default_reason = "WORLD_FAULTED"


class EntityNotFoundError(GenphysError):
    """The id never named anything."""

    default_reason = "ENTITY_NOT_FOUND"


class InvalidValueError(GenphysError):
    """Within its limits and still impossible, as an inertia that no body has or a name of the wrong form."""

    default_reason = "INVALID_VALUE"


class UnavailableError(GenphysError):
    """No server answers at the address, or the connection broke."""


class DeadlineExceededError(GenphysError):
    """The call took longer than its `timeout`; it may or may not have been done."""


class CancelledError(GenphysError):
    """The call was ended from this side, as by `close()` in another thread."""


class LaunchError(GenphysError):
    """The private server of `launch` was not found or did not start; the message says what to do."""


class EventsLeftOutWarning(RuntimeWarning):
    """A result of `World.step` has no room for all events: `StepResult.events_left_out` says which are missing."""


BY_REASON: dict[str, type[GenphysError]] = {
    kind.default_reason: kind for kind in GenphysError.__subclasses__() if kind.default_reason
}

_CODES: dict[int, grpc.StatusCode] = {code.value[0]: code for code in grpc.StatusCode}

_BY_CODE: dict[grpc.StatusCode, type[GenphysError]] = {
    grpc.StatusCode.UNAVAILABLE: UnavailableError,
    grpc.StatusCode.DEADLINE_EXCEEDED: DeadlineExceededError,
    grpc.StatusCode.CANCELLED: CancelledError,
}


def from_rpc_error(error: Any, *, ended_here: bool, request: Any = None) -> GenphysError:
    """Returns the exception that says what the status and details of a failed call of `request`, a class, say.

    A call that nobody cancelled on this side came to a server in its last moments: gRPC cancels what it can no longer
    answer, which is no other thing than not being there.
    """
    code = error.code()
    message = error.details() or code.name
    if code == grpc.StatusCode.CANCELLED and not ended_here:
        code, message = grpc.StatusCode.UNAVAILABLE, "the server ended the call without an answer: it is shutting down"
    reason, field, metadata = "", "", {}
    for detail in _details(error):
        kind = detail.type_url.rpartition("/")[2]
        if kind == "google.rpc.ErrorInfo":
            info = message_class(kind).FromString(detail.value)
            reason, metadata = info.reason, dict(info.metadata)
            if reason == "UNSPECIFIED":
                reason = ""  # no refusal: only its metadata says something
        elif kind == "google.rpc.BadRequest":
            violations = message_class(kind).FromString(detail.value).field_violations
            field = violations[0].field if violations else ""
    kind = BY_REASON.get(reason) or _BY_CODE.get(code, GenphysError)
    return _told(kind, message, request, reason=reason, field=field, code=code, metadata=metadata)


def from_refusal(refusal: Any) -> GenphysError:
    """Returns the exception that a Refusal of a step stands for, as a call of it alone would have raised it."""
    reason = enum_names("ErrorReason", "ERROR_REASON_").get(refusal.reason, "").upper()
    code = _CODES.get(refusal.code, grpc.StatusCode.UNKNOWN)
    kind = BY_REASON.get(reason) or _BY_CODE.get(code, GenphysError)
    metadata = _metadata_of(refusal.early_end) if refusal.HasField("early_end") else {}
    return _told(
        kind, refusal.message, wire.StepRequest, reason=reason, field=refusal.field, code=code, metadata=metadata
    )


def _told(kind: type[GenphysError], message: str, request: Any, *, field: str, **details: Any) -> GenphysError:
    """Returns an exception whose words are those of this package."""
    argument = None
    if request is not None:
        parts = _naming.parts_of(request.DESCRIPTOR, field) if field else None
        argument = None if parts is None else ".".join(parts)
        message = _naming.message_of(request.DESCRIPTOR, field, message)
    return kind(message, field=field, argument=argument, **details)


def created_ids(error: GenphysError) -> dict[int, int]:
    """Returns what the commands of a step that ended early created, by their place in it, as far as it is told."""
    created: dict[int, int] = {}
    for item in error.metadata.get(_CREATED_KEY, "").split():
        command, _, ids = item.partition(":")
        first, _, last = ids.partition("-")
        for number in range(int(first), int(last or first) + 1):
            created[int(command) + number - int(first)] = number
    return created


def _metadata_of(early_end: Any) -> dict[str, str]:
    runs: list[list[int]] = []  # command, first id, last id
    for command, number in enumerate(early_end.created_ids):
        if runs and [command, number] == [runs[-1][0] + runs[-1][2] - runs[-1][1] + 1, runs[-1][2] + 1]:
            runs[-1][2] = number
        elif number != 0:
            runs.append([command, number, number])
    metadata = {"steps_done": str(early_end.steps_done), "step": str(early_end.step)}
    if early_end.HasField("commands_done"):
        metadata["commands_done"] = str(early_end.commands_done)
    if runs:
        metadata[_CREATED_KEY] = " ".join(
            f"{command}:{first}" if first == last else f"{command}:{first}-{last}" for command, first, last in runs
        )
    return metadata


def _details(error: Any) -> list[Any]:
    for key, value in error.trailing_metadata() or ():
        if key == _DETAILS_KEY:
            return list(message_class("google.rpc.Status").FromString(value).details)
    return []

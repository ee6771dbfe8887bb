"""What a `with` block closes at its end."""

from __future__ import annotations

from types import TracebackType
from typing import TypeVar

AnyClosing = TypeVar("AnyClosing", bound="Closing")


class Closing:
    """Base of what is closed when it is no longer used."""

    __slots__ = ()

    def __enter__(self: AnyClosing) -> AnyClosing:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        raise NotImplementedError

    def __reduce__(self) -> str:
        raise TypeError(
            f"a {type(self).__name__} is a connection of this process, which can be neither pickled nor copied: "
            "pass on server.address and world.name, and use genphys.connect(address).world(name) there"
        )

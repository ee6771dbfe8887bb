"""What all verbs that change a world go through."""

from __future__ import annotations

from typing import Any

from . import _encode, fields
from ._contract import wire
from .joints import Joint
from .model import Entity


class Verbs:
    """What becomes of a verb: a `World` does it at once, a `Batch` keeps it."""

    _home: str
    """The name of the world that handles must be of."""

    def _create(self, entity: Any, verb: str = "") -> Entity:
        """Makes it; `verb` is what makes an entity of one shape, which errors then call as its arguments do."""
        raise NotImplementedError

    def _create_field(self, command: Any) -> fields.ForceField:
        raise NotImplementedError

    def _made_by(self, entity: Any) -> int | None:
        """Returns the place in the batch of the command that makes an entity which is not there yet."""
        return None

    def _submit(self, *commands: Any) -> None:
        """Does them, in this order, or none of them."""
        raise NotImplementedError

    def _join(self, joint: Any) -> Joint:
        raise NotImplementedError

    def _side(self, entity: Entity | int | None) -> Any:
        return None if entity is None else wire.EntityRef(id=_encode.entity_id(entity, self._home))


def has_rows(ids: bytes, **columns: bytes) -> bool:
    """Returns whether there is something to do; raises ValueError for rows of nobody."""
    for name, column in columns.items():
        if column and not ids:
            raise ValueError(f"{name} has rows, but nobody is named")
    return bool(ids)

"""What arguments must look like: ids, vectors and columns. What is wrong is told by the name of the argument.

The server checks values; here only what has no meaning at all is refused: TypeError for what is of another kind,
ValueError for what has another shape or is beyond what can be sent.
"""

from __future__ import annotations

import array
import math
import operator
import reprlib
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

ID_MAX = (1 << 64) - 1

_NO_VECTOR = (str, bytes, bytearray, Mapping, set, frozenset)
"""What can be iterated and has no three numbers in an order that anybody meant."""

_NUMERIC_KINDS = "biufO"


class Handle:
    """What names a thing of a world by its id. Each kind has ids of its own: one never stands for another."""

    __slots__ = ("_failed", "_world")

    def __init__(self, home: str) -> None:
        self._failed = False  # the batch that was to make it came to nothing
        self._world = home

    @property
    def _home(self) -> str:
        """The world that it is of, as in "worlds/lab"; empty: nobody said."""
        return self._world

    def __index__(self) -> int:
        raise NotImplementedError


def id_in_batch(handle: Any, what: str, meanwhile: str = "") -> int:
    """Returns the id of a handle; raises ValueError, which calls it `what`, for one of a batch that has none."""
    if handle._id is not None:
        return int(handle._id)
    if handle._failed:
        raise ValueError(f"{what} was not created: the step that took its batch along failed, and told of no id")
    raise ValueError(f"{what} is not created before the next step of its world has taken along its batch{meanwhile}")


def handle_id(value: Any, kinds: tuple[type[Handle], ...], what: str, home: str) -> int:
    """Returns the id of a handle of one of `kinds`, or of a number, for a call to the world `home`.

    Raises:
        TypeError: it is another kind of handle, a bool, or no number; `what` says what was expected.
        ValueError: it is a number that no id has, or its handle has no id yet, or is of another world.
    """
    if isinstance(value, kinds):
        if home and value._home and value._home != home:
            # Somebody else has that number here.
            raise ValueError(f"{value!r} is of the world {value._home}, not of {home}")
        return operator.index(value)
    if not isinstance(value, (Handle, bool, np.bool_)):
        try:
            number = operator.index(value)
        except TypeError:
            pass
        else:
            if 0 <= number <= ID_MAX:
                return number
            raise ValueError(f"{number} is no id: it is not from 0 to {ID_MAX}")
    raise TypeError(f"expected {what} or its id, not {type(value).__name__}")


def id_column(values: Any, what: str, home: str, id_of: Callable[[Any, str], int]) -> bytes:
    """Returns n ids as a byte column; an array of numbers takes the fast way."""
    if isinstance(values, np.ndarray) and values.dtype.kind in "iu":
        if values.ndim != 1:
            raise ValueError(f"{what} has shape {values.shape}, not (n,)")
        if values.dtype.kind == "i" and values.size and values.min() < 0:
            raise ValueError(f"{what} has {values.min()}, which is no id")
        return np.ascontiguousarray(values, "<u8").tobytes()
    if isinstance(values, (set, frozenset)):
        raise TypeError(f"{what} is a set, whose order says nothing of rows")
    return np.fromiter((id_of(each, home) for each in items(values, what)), "<u8").tobytes()


def items(values: Any, what: str) -> Iterable[Any]:
    """Returns `values`; raises TypeError if it is a single thing or a text in place of several."""
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise TypeError(f"{what} is {reprlib.repr(values)}, not a list")
    return values


def text(value: Any, what: str, example: str) -> str:
    """Returns `value`; raises TypeError, which shows an example, unless it is a text."""
    if not isinstance(value, str):
        raise TypeError(f"{what} is {reprlib.repr(value)}, not a text, as in {example}")
    if not value:
        raise ValueError(f"{what} is empty: it is a text as in {example}")
    return value


def instance(value: Any, kind: type, what: str, name: str | None = None) -> Any:
    """Returns `value`; raises TypeError unless it is one of `kind`, which the user calls genphys.`name`."""
    if not isinstance(value, kind):
        raise TypeError(f"{what} is {reprlib.repr(value)}, not genphys.{name or kind.__name__}(...)")
    return value


def numbers(value: Any, count: int, what: str) -> array.array[float]:
    """Returns `count` numbers; raises TypeError for what are none, ValueError for another count."""
    if isinstance(value, np.ndarray) and value.ndim != 1:
        raise ValueError(f"{what} has shape {value.shape}, not ({count},)")
    if isinstance(value, _NO_VECTOR):
        raise TypeError(f"{what} is {reprlib.repr(value)}, not {count} numbers")
    try:
        # Not by float(), which takes the text "1" for a number.
        found = array.array("d", iter(value))
    except TypeError:
        raise TypeError(f"{what} is {reprlib.repr(value)}, not {count} numbers") from None
    if len(found) != count:
        raise ValueError(f"{what} has {len(found)} numbers, not {count}")
    return found


def floats(values: Any, what: str) -> NDArray[np.float64]:
    """Returns an array of numbers of any shape; raises TypeError or ValueError for what is none."""
    try:
        found = np.asarray(values)
        # None would become NaN.
        if found.dtype.kind not in _NUMERIC_KINDS or (found.dtype.kind == "O" and any(each is None for each in found.flat)):
            raise TypeError
        return np.ascontiguousarray(found, "<f8") if found.ndim else found.astype("<f8")
    except TypeError:
        raise TypeError(f"{what} is {reprlib.repr(values)}, not an array of numbers") from None
    except ValueError:
        # Rows of unequal length, or a text among numbers.
        raise ValueError(f"{what} is {reprlib.repr(values)}, not an array of numbers") from None


def number_column(values: Any, what: str) -> bytes:
    """Returns an array of shape (n,) as a byte column; raises ValueError if it has another shape."""
    column = floats(values, what)
    if column.ndim != 1:
        raise ValueError(f"{what} has shape {column.shape}, not (n,)")
    return column.tobytes()


def row_column(values: Any, width: int, what: str) -> bytes:
    """Returns an array of shape (n, width) as a byte column; raises ValueError if it has another shape."""
    return rows(values, width, what).tobytes()


def rows(values: Any, width: int, what: str) -> NDArray[np.float64]:
    """Returns an array of shape (n, width); an empty list has no rows. Raises ValueError if it has another shape."""
    found = floats(values, what)
    if found.shape == (0,):
        return found.reshape(0, width)
    if found.ndim != 2 or found.shape[1] != width:
        raise ValueError(f"{what} has shape {found.shape}, not (n, {width})")
    return found


def seconds(value: Any, what: str) -> float:
    """Returns a number of seconds, infinity among them; raises TypeError or ValueError for what is none."""
    try:
        is_none = math.isnan(value)
    except TypeError:
        raise TypeError(f"{what} is {reprlib.repr(value)}, not a number of seconds") from None
    if is_none:
        raise ValueError(f"{what} is {value}, not a number of seconds")
    return float(value)

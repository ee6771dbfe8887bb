"""The wire contract at run time: message classes, enum numbers and method signatures."""

from __future__ import annotations

import functools
import reprlib
from collections.abc import Callable
from typing import Any, NamedTuple

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.descriptor import FieldDescriptor

from . import _descriptors, _naming

PACKAGE = "genphys.v1"


def _make_pool() -> descriptor_pool.DescriptorPool:
    # A pool of our own: in the default one, other packages may have registered their own google/rpc/status.proto.
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(_descriptors.load()).file:
        pool.AddSerializedFile(file.SerializeToString())
    return pool


POOL = _make_pool()

if hasattr(message_factory, "GetMessageClass"):
    _class_of = message_factory.GetMessageClass
else:  # protobuf before 4.22
    _class_of = message_factory.MessageFactory(POOL).GetPrototype


@functools.cache
def message_class(full_name: str) -> Any:
    """Returns the class of a message by its full name, as in "genphys.v1.Frame"."""
    return _class_of(POOL.FindMessageTypeByName(full_name))


class _Wire:
    """The messages of genphys.v1 as attributes: `wire.Frame`."""

    def __getattr__(self, name: str) -> Any:
        try:
            found = message_class(f"{PACKAGE}.{name}")
        except KeyError:
            raise AttributeError(name) from None
        setattr(self, name, found)
        return found


wire = _Wire()

_MEANT = {
    FieldDescriptor.CPPTYPE_BOOL: "True or False",
    FieldDescriptor.CPPTYPE_DOUBLE: "a number",
    FieldDescriptor.CPPTYPE_FLOAT: "a number",
    FieldDescriptor.CPPTYPE_STRING: "a str",
    FieldDescriptor.CPPTYPE_UINT32: f"a whole number from 0 to {(1 << 32) - 1}",
    FieldDescriptor.CPPTYPE_UINT64: f"a whole number from 0 to {(1 << 64) - 1}",
}


class _Make:
    """The messages of genphys.v1 made from what a user said: `make.StepRequest(steps=3)`.

    What a field cannot hold is a TypeError or ValueError that names the argument, which protobuf does not.
    """

    def __getattr__(self, name: str) -> Callable[..., Any]:
        kind = getattr(wire, name)

        def made(**values: Any) -> Any:
            try:
                return kind(**values)
            except (TypeError, ValueError, OverflowError):
                _blame(kind, values)
                raise

        setattr(self, name, made)
        return made


def _blame(kind: Any, values: dict[str, Any]) -> None:
    """Raises what is wrong with the first value that its field cannot hold, if there is one."""
    for name, value in values.items():
        field = kind.DESCRIPTOR.fields_by_name.get(name)
        if field is None:
            return
        try:
            kind(**{name: value})
        except (TypeError, ValueError, OverflowError) as error:
            meant = "bytes" if field.type == FieldDescriptor.TYPE_BYTES else _MEANT.get(field.cpp_type, "what it holds")
            if hasattr(getattr(kind(), name), "extend"):
                meant = f"a list, each {meant}"
            text = f"{_naming.name_of(kind.DESCRIPTOR, name) or name} is {reprlib.repr(value)}, not {meant}"
            raise (TypeError if isinstance(error, TypeError) else ValueError)(text) from None


make = _Make()


def enum_names(enum: str, prefix: str) -> dict[int, str]:
    """Returns number -> lower-case name without prefix of an enum; zero, the unspecified, is left out."""
    values = POOL.FindEnumTypeByName(f"{PACKAGE}.{enum}").values
    return {value.number: value.name.removeprefix(prefix).lower() for value in values if value.number != 0}


class EnumCodec:
    """Translates between the numbers of one enum and the words of this package."""

    def __init__(self, enum: str, prefix: str, what: str) -> None:
        self._words = enum_names(enum, prefix)
        self._numbers = {word: number for number, word in self._words.items()}
        self._what = what

    def number(self, word: str) -> int:
        """Returns the number of `word`; raises ValueError naming the words there are, TypeError for what is no word."""
        found = self._numbers.get(word.lower()) if isinstance(word, str) else None
        if found is not None:
            return found
        error = ValueError if isinstance(word, str) else TypeError
        raise error(f"{self._what} is {reprlib.repr(word)}, not one of: {', '.join(sorted(self._numbers))}")

    def word(self, number: int) -> str:
        """Returns the word of `number`; a number that this version does not know is given in digits."""
        return self._words.get(number, str(number))


MOTION = EnumCodec("MotionType", "MOTION_TYPE_", "motion")
MIXING = EnumCodec("Mixing", "MIXING_", "mixing")
COORDINATES = EnumCodec("Coordinates", "COORDINATES_", "coordinates")
SCALAR = EnumCodec("Scalar", "SCALAR_", "dtype")
SOLVER = EnumCodec("Stepper.Solver", "SOLVER_", "solver")
QUALITY = EnumCodec("Stepper.Quality", "QUALITY_", "quality")
FEATURE = EnumCodec("Feature", "FEATURE_", "feature")
WORLD_STATE = EnumCodec("World.State", "STATE_", "state")


class Method(NamedTuple):
    """One method of a service."""

    path: str
    request: Any
    response: Any
    server_streaming: bool
    client_streaming: bool


def _methods_of(service_name: str) -> dict[str, Method]:
    service = POOL.FindServiceByName(f"{PACKAGE}.{service_name}")
    proto = descriptor_pb2.ServiceDescriptorProto()
    service.CopyToProto(proto)
    return {
        method.name: Method(
            path=f"/{service.full_name}/{method.name}",
            request=_class_of(service.methods_by_name[method.name].input_type),
            response=_class_of(service.methods_by_name[method.name].output_type),
            server_streaming=method.server_streaming,
            client_streaming=method.client_streaming,
        )
        for method in proto.method
    }


METHODS: dict[str, Method] = {
    name: method
    for service in ("EngineService", "WorldService", "SimulationService")
    for name, method in _methods_of(service).items()
}

"""Shows the events of a world as they happen: `python -m genphys.watch [--address A] [world]`."""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import sys
from collections.abc import Sequence
from typing import Any

from . import events
from .errors import GenphysError, UnavailableError
from .fields import ForceField
from .model import Entity, EntityInfo
from .server import Server, connect
from .streams import AnyEvent
from .world import World

_DEFAULT_ADDRESS = "127.0.0.1:50051"
_EXIT_FAILED = 1
_EXIT_USAGE = 2


class _CannotChoose(Exception):
    """Which world to watch is not clear; the message says what to do."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command and returns its exit code: 0 at the end, 1 when a server refuses, 2 for a wrong question."""
    options = _parser().parse_args(arguments)
    try:
        with connect(options.address) as server:
            _watch(_choose(server, options.world), options)
    except _CannotChoose as error:
        print(error, file=sys.stderr)
        return _EXIT_USAGE
    except UnavailableError as error:
        print(f"{error.message}\nStart a server with script/server, or name another with --address.", file=sys.stderr)
        return _EXIT_FAILED
    except GenphysError as error:
        print(error, file=sys.stderr)
        return _EXIT_FAILED
    except KeyboardInterrupt:
        pass
    except BrokenPipeError:
        # The reader, as in `| head`, has seen enough; Python must not complain while it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m genphys.watch",
        description="Shows the events of a world as they happen, one per line, until Ctrl-C.",
    )
    parser.add_argument("world", nargs="?", help="name of the world; needed if the server has several")
    parser.add_argument(
        "--address",
        default=os.environ.get("GENPHYS_ADDRESS", _DEFAULT_ADDRESS),
        help="of the server, as in 127.0.0.1:50051 or unix:/path; default: $GENPHYS_ADDRESS, else %(default)s",
    )
    parser.add_argument("--json", action="store_true", help="one JSON object per line; ids are strings")
    parser.add_argument("--duration", type=float, metavar="SECONDS", help="end after so many seconds")
    return parser


def _choose(server: Server, name: str | None) -> World:
    if name:
        return server.world(name)
    names = [each.name for each in server.list_worlds()]
    if not names:
        raise _CannotChoose(
            f"The server at {server.address} has no world yet. Make one, as with genphys.connect().create_world(), "
            "and start this again."
        )
    if len(names) > 1:
        raise _CannotChoose("The server has several worlds. Say which one: " + ", ".join(names))
    return server.world(names[0])


def _watch(world: World, options: argparse.Namespace) -> None:
    with world.events(duration=options.duration) as stream:
        world.entities()  # For the names of those that were there before.
        # On stderr, so that stdout has events alone; it also tells scripts that nothing is missed from here on.
        print(f"watching {world.name} at {options.address}", file=sys.stderr, flush=True)
        for event in stream:
            print(json.dumps(to_json(event)) if options.json else to_line(event), flush=True)


def to_line(event: AnyEvent) -> str:
    """Returns an event as a line for people."""
    if isinstance(event, events.Gap):
        lost = event.last_sequence - event.first_sequence + 1
        return f"---- {lost} events lost: this watcher was too slow"
    if isinstance(event, events.EpochBegan):
        return "---- the world was reset: steps begin anew"
    describe = _LINES.get(type(event))
    return f"step {event.step:>8}  {describe(event) if describe else _words(type(event).__name__)}"


def to_json(event: AnyEvent) -> dict[str, Any]:
    """Returns an event as a dictionary that json can write; ids are strings, as they exceed what JavaScript keeps."""
    fields = {field.name: _plain(getattr(event, field.name)) for field in dataclasses.fields(event)}
    return {"kind": type(event).__name__, **fields}


def _plain(value: Any) -> Any:
    if isinstance(value, Entity):
        return {"id": str(value.id), "name": value.name}
    if isinstance(value, ForceField):
        return {"id": str(value.id)}
    if isinstance(value, EntityInfo):
        return {"position": list(value.position), "orientation": list(value.orientation), "motion": value.motion}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    return value


def _words(name: str) -> str:
    return "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in name).strip()


def _contact(event: events.ContactBegan | events.ContactPersisted, verb: str) -> str:
    text = f"{event.entity_a} and {event.entity_b} {verb}"
    if event.points:
        deepest = max(event.points, key=lambda point: point.depth)
        where = ", ".join(f"{each:.3f}" for each in deepest.position)
        text += f" at ({where}) m, {sum(point.normal_impulse for point in event.points):.3g} N*s"
    return text


def _moving(event: events.EntityStartedMoving | events.EntityStoppedMoving, verb: str) -> str:
    return f"{event.entity} {verb} {'rotating' if event.rotation else 'moving'}"


def _sides(event: events.JointBroke | events.JointCreated | events.JointUpdated | events.JointDeleted) -> str:
    return " and ".join("the world" if side is None else str(side) for side in (event.entity_a, event.entity_b))


_LINES: dict[type, Any] = {
    events.ContactBegan: lambda event: _contact(event, "touch"),
    events.ContactPersisted: lambda event: _contact(event, "still touch"),
    events.ContactEnded: lambda event: f"{event.entity_a} and {event.entity_b} part",
    events.SensorEntered: lambda event: f"{event.visitor} enters the sensor {event.sensor}",
    events.SensorLeft: lambda event: f"{event.visitor} leaves the sensor {event.sensor}",
    events.EntitySlept: lambda event: f"{event.entity} falls asleep",
    events.EntityWoke: lambda event: f"{event.entity} wakes up",
    events.EntityStartedMoving: lambda event: _moving(event, "starts"),
    events.EntityStoppedMoving: lambda event: _moving(event, "stops"),
    events.JointBroke: lambda event: (
        f"joint {event.joint} of {_sides(event)} breaks at {event.force:.3g} N, {event.torque:.3g} N*m"
    ),
    events.EntityFaulted: lambda event: f"{event.entity} left the bounds of the world and is disabled",
    events.EntityCreated: lambda event: f"{event.entity} appears",
    events.EntityUpdated: lambda event: f"{event.entity} is changed: {', '.join(event.changed)}",
    events.EntityDeleted: lambda event: f"{event.entity} is removed",
    events.JointCreated: lambda event: f"joint {event.joint} holds {_sides(event)}",
    events.JointUpdated: lambda event: f"joint {event.joint} of {_sides(event)} is changed: {', '.join(event.changed)}",
    events.JointDeleted: lambda event: f"joint {event.joint} of {_sides(event)} is removed",
    events.ForceFieldCreated: lambda event: f"force field {event.field} appears",
    events.ForceFieldUpdated: lambda event: f"force field {event.field} is changed",
    events.ForceFieldDeleted: lambda event: f"force field {event.field} is removed",
}


if __name__ == "__main__":
    sys.exit(main())

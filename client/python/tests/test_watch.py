"""`python -m genphys.watch` shows events to people and to programs, and says what to do when it cannot."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import time

import pytest
from fake_server import FakeServer, batch

import genphys
from genphys import fields, joints, watch
from genphys._contract import wire


SHORT_SECONDS = 0.3
PATIENCE_SECONDS = 10.0


def serving(*worlds, events=()):
    return FakeServer(
        ListWorlds=lambda request, context: wire.ListWorldsResponse(
            worlds=[{"name": f"worlds/{name}"} for name in worlds], stamps=[{} for _ in worlds]
        ),
        ListEntities=lambda request, context: wire.ListEntitiesResponse(entities=[{"id": 5, "display_name": "ball"}]),
        WatchEvents=lambda request, context: iter([batch(1, *events)]),
    )


TOUCH = {
    "contact_began": {
        "entity_a": 4,
        "entity_b": 5,
        "points": [{"position": {"x": 0.5, "z": 1.0}, "normal_impulse": 3.25}],
    }
}


def test_the_only_world_is_picked_and_its_events_are_lines(capsys):
    with serving("lab", events=[TOUCH, {"entity_slept": {"entity_id": 5}}]) as server:
        assert watch.main(["--address", server.address]) == 0

    output = capsys.readouterr()
    assert output.out.splitlines() == [
        "step        1  entity 4 and ball touch at (0.500, 0.000, 1.000) m, 3.25 N*s",
        "step        2  ball falls asleep",
    ]
    assert output.err == f"watching lab at {server.address}\n"


def test_json_has_one_object_per_line_with_ids_as_strings(capsys):
    with serving("lab", events=[TOUCH]) as server:
        assert watch.main(["--address", server.address, "--json", "lab"]) == 0

    (line,) = capsys.readouterr().out.splitlines()
    event = json.loads(line)
    assert (event["kind"], event["step"], event["sequence"]) == ("ContactBegan", 1, 1)
    assert event["entity_b"] == {"id": "5", "name": "ball"}
    assert event["points"][0]["position"] == [0.5, 0.0, 1.0]


def test_no_world_and_several_worlds_are_said_with_the_way_out(capsys):
    with serving() as server:
        assert watch.main(["--address", server.address]) == 2
    assert "create_world" in capsys.readouterr().err
    with serving("lab", "moon") as server:
        assert watch.main(["--address", server.address]) == 2
    assert "Say which one: lab, moon" in capsys.readouterr().err


def test_no_server_is_said_with_the_way_out(capsys):
    with serving() as server:
        address = server.address
    assert watch.main(["--address", address]) == 1
    assert "script/server" in capsys.readouterr().err


def test_help_explains_the_command(capsys):
    with pytest.raises(SystemExit) as end:
        watch.main(["--help"])

    assert end.value.code == 0
    assert "--json" in capsys.readouterr().out


def every_event():
    """One of each kind, made from the declared fields, so that a new kind is covered too."""
    samples = {
        "entity_a": genphys.Entity(1, "crate"),
        "entity_b": genphys.Entity(2, "ball"),
        "entity": genphys.Entity(2, "ball"),
        "sensor": genphys.Entity(1, "gate"),
        "visitor": genphys.Entity(2, "ball"),
        "points": (),
        "rotation": True,
        "joint": 3,
        "force": 1.0,
        "torque": 2.0,
        "info": None,
        "description": joints.Hinge(upper=1.0),
        "field": 4,
        "changed": ("pose",),
    }
    of_field = genphys.ForceFieldInfo(
        force_field=fields.ForceField(4), field=fields.Drag(linear=0.5), entities=(2,), region=None
    )
    for kind in genphys.Event.__subclasses__():
        names = [name for name in kind.__dataclass_fields__ if name not in ("step", "sequence")]
        given = samples | ({"info": of_field} if "field" in names else {})
        yield kind(7, 8, *(given[name] for name in names))
    yield genphys.Event(7, 8)
    yield genphys.Gap(1, 3)
    yield genphys.EpochBegan(9)


@pytest.mark.parametrize("event", list(every_event()), ids=lambda event: type(event).__name__)
def test_every_kind_of_event_has_a_line_and_a_json(event):
    line = watch.to_line(event)

    assert "<" not in line and "object" not in line
    assert json.loads(json.dumps(watch.to_json(event)))["kind"] == type(event).__name__
    named = getattr(event, "entities", ())
    assert all(entity.name in line for entity in named)


def test_ctrl_c_ends_it_in_peace(server):
    with server.create_world(name="watched") as world:
        program = subprocess.Popen(
            [sys.executable, "-m", "genphys.watch", "--address", server.address, world.name],
            env={**os.environ, "PYTHONPATH": str(pathlib.Path(genphys.__file__).parents[1])},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        line = program.stderr.readline()  # it watches by then
        time.sleep(SHORT_SECONDS)
        program.send_signal(signal.SIGINT)
        _, complaints = program.communicate(timeout=PATIENCE_SECONDS)

    assert line.startswith(b"watching watched")
    assert (program.returncode, complaints) == (0, b"")

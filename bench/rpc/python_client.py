#!/usr/bin/python3
"""Measures the Python client: started by the benchmark, which says on standard input what to do.

Usage: python_client.py <address of the server>

Prints the versions that it runs with as one line of JSON. Then answers each line "<what> <world> <count>" by as many
numbers in one line:

  cycle   takes so many steps, and prints how long each took, in nanoseconds
  forces  pushes every entity so many times in columns, and prints the forces per second of each call
  numpy   turns the bytes of a reply to a step into arrays, and prints how long it took, in microseconds
  frames  views the world while it plays as fast as it can, and prints the frames per second of so many stretches
"""

from __future__ import annotations

import importlib.metadata
import json
import platform
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np

import genphys
from genphys._contract import wire

_STRETCH = 500


def cycles(world: genphys.World, count: int) -> Iterator[float]:
    """Takes steps and looks at every column of the frames."""
    for _ in range(count):
        begin = time.perf_counter_ns()
        _look(world.step())
        yield time.perf_counter_ns() - begin


def forces(world: genphys.World, count: int) -> Iterator[float]:
    """Pushes all entities, from arrays."""
    ids = world.step(0).ids
    pushes = np.tile([0.0, 0.0, 1.0], (len(ids), 1))
    for _ in range(count):
        begin = time.perf_counter_ns()
        with world.batch() as batch:
            batch.apply_forces(ids, pushes)
        world.step(0, frame=False, events=False)
        yield len(ids) / (1e-9 * (time.perf_counter_ns() - begin))
        # Used up, or they would pile up.
        world.step(1, frame=False, events=False)


def to_numpy(world: genphys.World, count: int) -> Iterator[float]:
    """Reads the same reply again and again."""
    request = world._step_request(1, frame=True, events=False, stats=False, step_size=None, expected_step=None)
    prepared = world._take_along(request)
    response = world._connection.call("Step", prepared.request)
    for _ in range(count):
        # Protobuf keeps what it has handed out, so that each pass needs a message of its own.
        fresh = wire.StepResponse.FromString(response.SerializeToString())
        begin = time.perf_counter_ns()
        _look(prepared.result(fresh))
        yield 1e-3 * (time.perf_counter_ns() - begin)


def frames(world: genphys.World, count: int) -> Iterator[float]:
    """Counts what a viewer is pushed."""
    world.play(0)
    with world.frames(genphys.FrameRequest(velocities=False)) as stream:
        next(stream)
        for _ in range(count):
            begin = time.perf_counter_ns()
            for _ in range(_STRETCH):
                next(stream).positions  # noqa: B018
            yield _STRETCH / (1e-9 * (time.perf_counter_ns() - begin))
    world.pause()


def _look(result: genphys.Frame) -> None:
    for column in (result.positions, result.orientations, result.linear_velocities, result.angular_velocities):
        if len(column) != len(result):
            raise RuntimeError("a column of the frame is missing")


_ANSWERS: dict[str, Callable[[genphys.World, int], Iterator[float]]] = {
    "cycle": cycles,
    "forces": forces,
    "numpy": to_numpy,
    "frames": frames,
}


def main() -> None:
    versions = {"python": platform.python_version()}
    versions |= {name: importlib.metadata.version(name) for name in ("grpcio", "protobuf", "numpy")}
    print(json.dumps(versions), flush=True)
    worlds: dict[str, genphys.World] = {}
    with genphys.connect(sys.argv[1]) as server:
        for line in sys.stdin:
            what, name, count = line.split()
            if name not in worlds:
                worlds[name] = server.world(name)
            print(*_ANSWERS[what](worlds[name], int(count)), flush=True)


if __name__ == "__main__":
    main()

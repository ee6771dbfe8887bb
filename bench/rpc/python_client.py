#!/usr/bin/python3
"""Measures cycles of the Python client: started by the benchmark, which says on standard input what to do.

Usage: python_client.py <address of the server>

Prints the versions that it runs with as one line of JSON. Then, for each line "<world> <steps>", takes so many steps
and prints how long each took, in nanoseconds.
"""

import importlib.metadata
import json
import platform
import sys
import time

import genphys


def cycle(world: genphys.World) -> int:
    """Takes one step and looks at every column of the frame; returns how long that took."""
    begin = time.perf_counter_ns()
    result = world.step()
    for column in (result.positions, result.orientations, result.linear_velocities, result.angular_velocities):
        if len(column) != len(result):
            raise RuntimeError("a column of the frame is missing")
    return time.perf_counter_ns() - begin


def main() -> None:
    versions = {"python": platform.python_version()}
    versions |= {name: importlib.metadata.version(name) for name in ("grpcio", "protobuf", "numpy")}
    print(json.dumps(versions), flush=True)
    worlds: dict[str, genphys.World] = {}
    with genphys.connect(sys.argv[1]) as server:
        for line in sys.stdin:
            name, steps = line.split()
            if name not in worlds:
                worlds[name] = server.world(name)
            print(*(cycle(worlds[name]) for _ in range(int(steps))), flush=True)


if __name__ == "__main__":
    main()

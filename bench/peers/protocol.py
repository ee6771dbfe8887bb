"""What a peer is: a program that simulates scenes as it is told on its standard input.

A request is a line with a JSON array, of which the first element is one of

    about                                        what simulates: name, version, settings
    start <scene>                                ends the scene before, if there was one
    step <size in s> <count>
    time <size in s> <count>                     the same, answered with the processor time that it took, s
    state                                        13 numbers a body: position, orientation w x y z, velocity, spin
    hold <body> <x y z of force> <x y z of torque>   from now on, through the centre of mass
    kick <body> <x y z of impulse>               through the centre of mass
    gravity <x> <y> <z>
    remove <body>                                its numbers no longer count
    release <joint>

Only about, start, time and state are answered, by a line: "ok" and what was asked for, or "no" and why not. What goes
wrong in another request is the answer to the next one that has one, and to all others until the next start.

Numbers are SI, in world coordinates, velocities are those of centres of mass, which are the origins of bodies' frames.
Bodies and joints are named by their places. A scene is

    {"gravity": [x, y, z], "ground": whether there is a plane at z = 0, "friction": of all, "restitution": of all,
     "bodies": [{"shape": {"kind": ..., ...}, "position": [x, y, z], "orientation": [w, x, y, z], "velocity": [x, y, z],
                 "spin": [x, y, z], "mass": null if it is static, "tensor": [xx, yy, zz, xy, xz, yz]}],
     "joints": [{"kind": "ball", "hinge" or "slider", the latter two of z, "a": null for the world, "b": ...,
                 "in_a": {"position": ..., "orientation": ...}, "in_b": ...}]}

with the shapes sphere (radius), box (half_extents), capsule and cylinder (radius, half_length of the straight part,
along z), plane (normal, offset; static), hull (points) and mesh (points, indices; static). Bodies that a joint connects
do not touch each other. protocol.mjs is the same for Node.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from typing import Any

TIME_MAX = 20
"""s of processor time that one request may take: who needs more is too slow to be measured."""

Scene = dict[str, Any]


class Refused(Exception):
    """What an engine cannot do; the text names it."""


class World:
    """A scene in the hands of an engine. What a subclass leaves out is refused."""

    def step(self, size: float, count: int) -> None:
        raise NotImplementedError

    def state(self) -> list[float]:
        raise NotImplementedError

    def hold(self, body: int, fx: float, fy: float, fz: float, tx: float, ty: float, tz: float) -> None:
        raise Refused("forces that go on")

    def kick(self, body: int, x: float, y: float, z: float) -> None:
        raise Refused("impulses")

    def gravity(self, x: float, y: float, z: float) -> None:
        raise Refused("gravity that changes")

    def remove(self, body: int) -> None:
        raise Refused("bodies that are removed")

    def release(self, joint: int) -> None:
        raise Refused("joints that are removed")


def refuse_restitution(scene: Scene) -> None:
    if scene["restitution"] > 0:
        raise Refused("restitution: its contacts have no such coefficient")


def principal_moments(tensor: list[float]) -> list[float]:
    """About the axes of the body, which must be those of the tensor."""
    rounding = 1e-12 * max(tensor[:3])
    if max(map(abs, tensor[3:])) > rounding:
        raise Refused("tensors whose axes are not the body's")
    return tensor[:3]


def run(world: World, size: float, count: int) -> float:
    """Takes the steps and returns the processor time of it, s, the whole process's."""
    begin, spent, done, together = time.process_time(), 0.0, 0, 8
    while done < count:
        if spent > TIME_MAX:
            raise Refused(f"slow: {count} steps take more than {TIME_MAX} s")
        many = min(together, count - done)
        world.step(size, many)
        done += many
        spent = time.process_time() - begin
        # As few looks at the clock as the limit needs.
        together = 2 * together if spent < 0.01 else together
    return spent


class _Desk:
    """Takes requests for one program."""

    def __init__(self, about: dict[str, str], start: Callable[[Scene], World]) -> None:
        self._about = about
        self._start = start
        self._world: World | None = None
        self._failure = "no scene was started"

    def answer(self, verb: str, arguments: list[Any]) -> str | None:
        if verb == "about":
            return "ok " + json.dumps(self._about)
        try:
            if verb == "start":
                # The old one goes first: some engines can have one at a time only.
                self._world = None
                self._world = self._start(*arguments)
            if self._world is None:
                return f"no {self._failure}" if verb in ("time", "state") else None
            return self._obey(self._world, verb, arguments)
        except Exception as exception:  # noqa: BLE001 whatever an engine throws is what became of the scene
            self._world = None
            self._failure = " ".join(str(exception).split()) or type(exception).__name__
            return f"no {self._failure}" if verb in ("start", "time", "state") else None

    def _obey(self, world: World, verb: str, arguments: list[Any]) -> str | None:
        if verb == "start":
            return "ok"
        if verb == "time":
            return f"ok {run(world, *arguments)!r}"
        if verb == "state":
            return "ok " + " ".join(map(repr, world.state()))
        if verb == "step":
            run(world, *arguments)
        else:
            {"hold": world.hold, "kick": world.kick, "gravity": world.gravity, "remove": world.remove,
             "release": world.release}[verb](*arguments)
        return None


def serve(name: str, version: str, settings: str, start: Callable[[Scene], World]) -> None:
    """Obeys until the input ends. `start` makes a world of a scene, or raises Refused."""
    # Engines greet on the standard output, which is for answers alone.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    desk = _Desk({"name": name, "version": version, "settings": settings}, start)
    for line in sys.stdin:
        verb, *arguments = json.loads(line)
        answer = desk.answer(verb, arguments)
        if answer is not None:
            answers.write(answer + "\n")
            answers.flush()

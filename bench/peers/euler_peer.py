"""A peer that needs nothing: bodies in free flight by semi-implicit Euler, so that what the benchmark must find is
known. It is there for the tests of the protocol.
"""

from __future__ import annotations

import math

from joint_tree import multiply
from protocol import Refused, Scene, World, serve


class EulerWorld(World):
    def __init__(self, scene: Scene) -> None:
        if scene["joints"]:
            raise Refused("joints")
        if scene["ground"] or any(body["mass"] is None for body in scene["bodies"]):
            raise Refused("contacts")
        self._gravity = scene["gravity"]
        self._bodies = [[*b["position"], *b["orientation"], *b["velocity"], *b["spin"]] for b in scene["bodies"]]
        self._mass = [[b["mass"]] * 3 + b["tensor"][:3] for b in scene["bodies"]]
        self._held = [[0.0] * 6 for _ in scene["bodies"]]

    def step(self, size: float, count: int) -> None:
        for _ in range(count):
            for body, mass, held in zip(self._bodies, self._mass, self._held):
                self._move(body, mass, held, size)

    def _move(self, body: list[float], mass: list[float], held: list[float], size: float) -> None:
        for i in range(6):
            body[7 + i] += size * (held[i] / mass[i] + (self._gravity[i] if i < 3 else 0.0))
        body[:3] = [x + size * v for x, v in zip(body[:3], body[7:10])]
        angle = size * math.hypot(*body[10:])
        if angle > 0:
            part = math.sin(angle / 2) * size / angle
            body[3:7] = multiply([math.cos(angle / 2), *(part * w for w in body[10:])], body[3:7])

    def state(self) -> list[float]:
        return [number for body in self._bodies for number in body]

    def hold(self, body: int, *wrench: float) -> None:
        self._held[body] = list(wrench)

    def kick(self, body: int, *impulse: float) -> None:
        for i in range(3):
            self._bodies[body][7 + i] += impulse[i] / self._mass[body][i]

    def gravity(self, *gravity: float) -> None:
        self._gravity = list(gravity)


if __name__ == "__main__":
    serve("Euler", "1", "semi-implicit Euler, written in Python", EulerWorld)

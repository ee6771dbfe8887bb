"""Bodies as a tree of joints, for engines whose coordinates are those of joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from protocol import Refused, Scene


@dataclass
class Link:
    """A moving body and what it hangs on."""

    body: int
    parent: int | None
    """Another body; none: the world, or nothing if there is no joint."""
    joint: dict[str, Any] | None
    in_parent: dict[str, Any] | None
    """The frame of the joint in its parent, and in the body."""
    in_body: dict[str, Any] | None


def links(scene: Scene) -> list[Link]:
    """All that move, parents before children. Loops of joints are refused."""
    joints = scene["joints"]
    moves = [body["mass"] is not None for body in scene["bodies"]]
    ends: dict[int | None, list[tuple[int, int | None, str, str]]] = {}
    for place, joint in enumerate(joints):
        a = joint["a"] if joint["a"] is not None and moves[joint["a"]] else None
        if a is None and joint["a"] is not None:
            raise Refused("joints to static bodies")
        ends.setdefault(a, []).append((place, joint["b"], "in_a", "in_b"))
        ends.setdefault(joint["b"], []).append((place, a, "in_b", "in_a"))
    found: list[Link] = []
    known: set[int | None] = {None}
    used: set[int] = set()

    def follow(begin: int | None) -> None:
        waiting = [begin]
        while waiting:
            parent = waiting.pop(0)
            for place, body, near, far in ends.get(parent, []):
                if place in used:
                    continue
                used.add(place)
                if body in known:
                    raise Refused("loops of joints: its coordinates are those of a tree")
                known.add(body)
                found.append(Link(body, parent, joints[place], joints[place][near], joints[place][far]))
                waiting.append(body)

    follow(None)
    for body, is_moving in enumerate(moves):
        if is_moving and body not in known:
            known.add(body)
            found.append(Link(body, None, None, None, None))
            follow(body)
    return found


def rotate(q: list[float], v: list[float]) -> list[float]:
    """The vector in the frame in which the quaternion (w x y z) is told."""
    w, x, y, z = q
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return [v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx]


def multiply(a: list[float], b: list[float]) -> list[float]:
    """Quaternions (w x y z): first b, then a."""
    (p, q, r, s), (w, x, y, z) = a, b
    return [p * w - q * x - r * y - s * z, p * x + q * w + r * z - s * y,
            p * y - q * z + r * w + s * x, p * z + q * y - r * x + s * w]


def inverse(q: list[float]) -> list[float]:
    return [q[0], -q[1], -q[2], -q[3]]


def upright(normal: list[float]) -> list[float]:
    """A quaternion that turns z to `normal`, of unit length."""
    x, y, z = normal
    if z < -1 + 1e-12:
        return [0.0, 1.0, 0.0, 0.0]
    w = ((1 + z) / 2) ** 0.5
    return [w, -y / (2 * w), x / (2 * w), 0.0]


def local(place: dict[str, Any], other: dict[str, Any]) -> tuple[list[float], list[float]]:
    """Position and orientation of `other` in the frame of `place`; both are bodies or frames in one frame."""
    back = inverse(place["orientation"])
    apart = [o - p for o, p in zip(other["position"], place["position"])]
    return rotate(back, apart), multiply(back, other["orientation"])

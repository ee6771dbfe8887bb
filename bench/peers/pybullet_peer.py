"""PyBullet as a peer: multibodies in joint coordinates, as it makes them unless asked otherwise."""

from __future__ import annotations

import importlib.metadata
import math
from typing import Any

import pybullet

import joint_tree
from protocol import Refused, Scene, World, principal_moments, serve

KINDS = {"ball": pybullet.JOINT_SPHERICAL, "hinge": pybullet.JOINT_REVOLUTE, "slider": pybullet.JOINT_PRISMATIC}
CLIENT = pybullet.connect(pybullet.DIRECT)
UNLIMITED = 1e9
"""m/s and rad/s: it holds coordinates to 100 of each otherwise."""


def swapped(q: Any) -> list[float]:
    """Ours begin with w, its end with it."""
    return [q[1], q[2], q[3], q[0]]


class PybulletWorld(World):
    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        # Connecting costs as much as many steps, and there is one world at a time.
        self._client = CLIENT
        pybullet.resetSimulation(self._client)
        self._held: dict[int, tuple[float, ...]] = {}
        self._size: float | None = None
        self._places: dict[int, tuple[int, int]] = {}
        """Of bodies: its number of the multibody, and of the link in it; -1 is the base."""
        self.gravity(*scene["gravity"])
        if scene["ground"]:
            self._finish(self._make(self._shape({"kind": "plane", "normal": [0, 0, 1]})), -1)
        for place, body in enumerate(scene["bodies"]):
            if body["mass"] is None:
                self._give_static(place, body)
        links = joint_tree.links(scene)
        for link in links:
            if link.joint is None or link.parent is None:
                self._give_tree(link, links)

    def _make(self, shape: int, **more: Any) -> int:
        return pybullet.createMultiBody(baseCollisionShapeIndex=shape, physicsClientId=self._client, **more)

    def _shape(self, shape: dict[str, Any], position: Any = (0, 0, 0), turn: Any = (1, 0, 0, 0)) -> int:
        client = {"physicsClientId": self._client, "collisionFramePosition": position,
                  "collisionFrameOrientation": swapped(turn)}
        match shape["kind"]:
            case "sphere":
                return pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=shape["radius"], **client)
            case "box":
                return pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=shape["half_extents"], **client)
            case "capsule" | "cylinder" as kind:
                form = pybullet.GEOM_CAPSULE if kind == "capsule" else pybullet.GEOM_CYLINDER
                size = {"radius": shape["radius"], "height": 2 * shape["half_length"]}
                return pybullet.createCollisionShape(form, **size, **client)
            case "plane":
                return pybullet.createCollisionShape(pybullet.GEOM_PLANE, planeNormal=shape["normal"], **client)
            case "hull":
                return pybullet.createCollisionShape(pybullet.GEOM_MESH, vertices=shape["points"], **client)
            case "mesh":
                return pybullet.createCollisionShape(pybullet.GEOM_MESH, vertices=shape["points"],
                                                     indices=[round(each) for each in shape["indices"]],
                                                     flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH, **client)
            case other:
                raise Refused(f"shapes of the kind {other}")

    def _give_static(self, place: int, body: dict[str, Any]) -> None:
        position = body["position"]
        if body["shape"]["kind"] == "plane":
            normal = joint_tree.rotate(body["orientation"], body["shape"]["normal"])
            position = [p + body["shape"]["offset"] * n for p, n in zip(position, normal)]
        made = self._make(self._shape(body["shape"]), baseMass=0, basePosition=position,
                          baseOrientation=swapped(body["orientation"]))
        self._finish(made, -1)
        self._places[place] = (made, -1)

    def _finish(self, made: int, link: int, body: dict[str, Any] | None = None) -> None:
        """What cannot be told when a body is made."""
        # It multiplies the coefficients of both bodies.
        pybullet.changeDynamics(
            made, link, lateralFriction=math.sqrt(self._scene["friction"]),
            restitution=math.sqrt(self._scene["restitution"]), physicsClientId=self._client)
        if body is None:
            return
        pybullet.changeDynamics(
            made, link, linearDamping=0, angularDamping=0, jointDamping=0, maxJointVelocity=UNLIMITED,
            physicsClientId=self._client)
        # Told together with any of the above it is not heard.
        moments = principal_moments(body["tensor"])
        pybullet.changeDynamics(made, link, localInertiaDiagonal=moments, physicsClientId=self._client)

    def _give_tree(self, root: joint_tree.Link, links: list[joint_tree.Link]) -> None:
        """A multibody: what moves freely and hangs on that, or what hangs on a place of the world."""
        bodies = self._scene["bodies"]
        members = [] if root.joint is None else [root]
        tree = {root.body}
        for link in links:
            if link.parent in tree and link.parent is not None:
                tree.add(link.body)
                members.append(link)
        numbers = {link.body: number for number, link in enumerate(members)}
        # The frame of a link is that of its joint, from which its centre of mass may be away.
        frames = {link.body: link.in_body for link in members}
        origin = {"position": [0, 0, 0], "orientation": [1, 0, 0, 0]}
        near = []
        for link in members:
            parent = frames.get(link.parent, origin)
            near.append(joint_tree.local(parent, link.in_parent))
        far = [joint_tree.local(link.in_body, origin) for link in members]
        free = bodies[root.body] if root.joint is None else None
        made = self._make(
            -1 if free is None else self._shape(free["shape"]), baseMass=0 if free is None else free["mass"],
            basePosition=[0, 0, 0] if free is None else free["position"],
            baseOrientation=[0, 0, 0, 1] if free is None else swapped(free["orientation"]),
            linkMasses=[bodies[link.body]["mass"] for link in members],
            linkCollisionShapeIndices=[self._shape(bodies[link.body]["shape"], *place)
                                       for link, place in zip(members, far)],
            linkVisualShapeIndices=[-1] * len(members),
            linkPositions=[position for position, _ in near], linkOrientations=[swapped(turn) for _, turn in near],
            linkInertialFramePositions=[position for position, _ in far],
            linkInertialFrameOrientations=[swapped(turn) for _, turn in far],
            linkParentIndices=[0 if link.parent not in numbers else numbers[link.parent] + 1 for link in members],
            linkJointTypes=[KINDS[link.joint["kind"]] for link in members], linkJointAxis=[[0, 0, 1]] * len(members))
        if free is not None:
            self._finish(made, -1, free)
            self._places[root.body] = (made, -1)
            pybullet.resetBaseVelocity(made, free["velocity"], free["spin"], physicsClientId=self._client)
        for number, link in enumerate(members):
            self._finish(made, number, bodies[link.body])
            self._places[link.body] = (made, number)
            self._let_go(made, number, link)

    def _let_go(self, made: int, number: int, link: joint_tree.Link) -> None:
        """Of the motor that each joint begins with."""
        body = self._scene["bodies"][link.body]
        if link.joint["kind"] == "ball":
            pybullet.setJointMotorControlMultiDof(
                made, number, pybullet.POSITION_CONTROL, targetPosition=[0, 0, 0, 1], positionGain=0, velocityGain=0,
                force=[0, 0, 0], physicsClientId=self._client)
        else:
            pybullet.setJointMotorControl2(
                made, number, pybullet.VELOCITY_CONTROL, force=0, physicsClientId=self._client)
        if any(body["velocity"] + body["spin"]):
            if link.joint["kind"] != "ball" or link.parent is not None:
                raise Refused("velocities of what hangs on joints, but for a ball of the world")
            spin = joint_tree.rotate(joint_tree.inverse(body["orientation"]), body["spin"])
            pybullet.resetJointStateMultiDof(made, number, [0, 0, 0, 1], spin, physicsClientId=self._client)

    def step(self, size: float, count: int) -> None:
        if size != self._size:
            pybullet.setTimeStep(size, physicsClientId=self._client)
            self._size = size
        step, client = pybullet.stepSimulation, self._client
        for _ in range(count):
            if self._held:
                self._push()
            step(client)

    def _push(self) -> None:
        for body, wrench in self._held.items():
            made, link = self._places[body]
            position = self._motion(body)[:3]
            pybullet.applyExternalForce(made, link, wrench[:3], position, pybullet.WORLD_FRAME, self._client)
            pybullet.applyExternalTorque(made, link, wrench[3:], pybullet.WORLD_FRAME, self._client)

    def _motion(self, body: int) -> list[float]:
        made, link = self._places[body]
        if link < 0:
            position, turn = pybullet.getBasePositionAndOrientation(made, self._client)
            velocity, spin = pybullet.getBaseVelocity(made, self._client)
        else:
            state = pybullet.getLinkState(made, link, 1, 1, self._client)
            position, turn, velocity, spin = state[0], state[1], state[6], state[7]
        return [*position, turn[3], *turn[:3], *velocity, *spin]

    def state(self) -> list[float]:
        gone = [0.0, 0.0, 0.0, 1.0] + [0.0] * 9
        return [number for body in range(len(self._scene["bodies"]))
                for number in (self._motion(body) if body in self._places else gone)]

    def hold(self, body: int, *wrench: float) -> None:
        self._held[body] = wrench

    def kick(self, body: int, *impulse: float) -> None:
        made, link = self._places[body]
        if link >= 0:
            raise Refused("impulses on what has joints")
        velocity, spin = pybullet.getBaseVelocity(made, self._client)
        mass = self._scene["bodies"][body]["mass"]
        pybullet.resetBaseVelocity(made, [v + i / mass for v, i in zip(velocity, impulse)], spin, self._client)

    def gravity(self, x: float, y: float, z: float) -> None:
        pybullet.setGravity(x, y, z, physicsClientId=self._client)

    def remove(self, body: int) -> None:
        made, link = self._places[body]
        if link >= 0:
            raise Refused("bodies that are removed from joints")
        pybullet.removeBody(made, self._client)
        del self._places[body]


if __name__ == "__main__":
    serve("PyBullet", importlib.metadata.version("pybullet"),
          "double precision, coordinates of joints: multibodies, as it makes them by default; damping (0.04 by "
          "default) zero, motors of joints off, velocities not held to 100; friction and restitution the roots of those "
          "asked for: it multiplies", PybulletWorld)

"""MuJoCo as a peer.

Usage: mujoco_peer.py [--rk4]
"""

from __future__ import annotations

import sys
from typing import Any

import mujoco
import numpy

import joint_tree
from protocol import Refused, Scene, World, principal_moments, refuse_restitution, serve

KINDS = {"ball": mujoco.mjtJoint.mjJNT_BALL, "hinge": mujoco.mjtJoint.mjJNT_HINGE,
         "slider": mujoco.mjtJoint.mjJNT_SLIDE}
# What it says when it takes the scene back to its beginning, in silence but for a count.
ALARMS = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
UNREACHED = 1e-9
"""m/s or rad/s by which a velocity asked for may differ from the nearest that joints allow."""


def give_shape(geom: Any, shape: dict[str, Any]) -> None:
    types = mujoco.mjtGeom
    match shape["kind"]:
        case "sphere":
            geom.type, geom.size = types.mjGEOM_SPHERE, [shape["radius"], 0, 0]
        case "box":
            geom.type, geom.size = types.mjGEOM_BOX, shape["half_extents"]
        case "capsule":
            geom.type, geom.size = types.mjGEOM_CAPSULE, [shape["radius"], shape["half_length"], 0]
        case "cylinder":
            geom.type, geom.size = types.mjGEOM_CYLINDER, [shape["radius"], shape["half_length"], 0]
        case "plane":
            # The last number is of how it would be drawn.
            geom.type, geom.size = types.mjGEOM_PLANE, [0, 0, 1]
        case other:
            # A mesh stands for its hull there, and so far no scene has a hull without restitution.
            raise Refused(f"shapes of the kind {other}")


class MujocoWorld(World):
    def __init__(self, scene: Scene, is_rk4: bool) -> None:
        refuse_restitution(scene)
        self._scene = scene
        spec = mujoco.MjSpec()
        spec.option.gravity = scene["gravity"]
        if is_rk4:
            spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
        if scene["ground"]:
            self._give_geom(spec.worldbody, {"kind": "plane"})
        bodies: dict[int | None, Any] = {None: spec.worldbody}
        for place, body in enumerate(scene["bodies"]):
            if body["mass"] is None:
                self._give_static(spec.worldbody, body)
        links = joint_tree.links(scene)
        for link in links:
            bodies[link.body] = self._give_body(spec, bodies[link.parent], link)
            if link.parent is not None:
                exclude = spec.add_exclude()
                exclude.bodyname1, exclude.bodyname2 = str(link.parent), str(link.body)
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        self._ids = [self._model.body(str(i)).id if body["mass"] is not None else None
                     for i, body in enumerate(scene["bodies"])]
        self._give_velocities()

    def _give_geom(self, body: Any, shape: dict[str, Any]) -> Any:
        geom = body.add_geom()
        give_shape(geom, shape)
        friction = self._scene["friction"]
        geom.friction = [friction, geom.friction[1], geom.friction[2]]
        # Its least coefficient is not zero.
        geom.condim = 3 if friction > 0 else 1
        return geom

    def _give_static(self, world: Any, body: dict[str, Any]) -> None:
        geom = self._give_geom(world, body["shape"])
        if body["shape"]["kind"] == "plane":
            normal = joint_tree.rotate(body["orientation"], body["shape"]["normal"])
            geom.quat = joint_tree.upright(normal)
            geom.pos = [p + body["shape"]["offset"] * n for p, n in zip(body["position"], normal)]
        else:
            geom.pos, geom.quat = body["position"], body["orientation"]

    def _give_body(self, spec: Any, parent: Any, link: joint_tree.Link) -> Any:
        asked = self._scene["bodies"][link.body]
        body = parent.add_body()
        body.name = str(link.body)
        body.pos, body.quat = asked["position"], asked["orientation"]
        if link.parent is not None:
            body.pos, body.quat = joint_tree.local(self._scene["bodies"][link.parent], asked)
        body.explicitinertial, body.ipos = True, [0, 0, 0]
        body.mass, body.inertia = asked["mass"], principal_moments(asked["tensor"])
        self._give_geom(body, asked["shape"])
        if link.joint is None:
            body.add_freejoint()
        else:
            joint = body.add_joint()
            joint.type = KINDS[link.joint["kind"]]
            joint.pos = link.in_body["position"]
            joint.axis = joint_tree.rotate(link.in_body["orientation"], [0, 0, 1])
        return body

    def _give_velocities(self) -> None:
        moving = [(i, body) for i, body in zip(self._ids, self._scene["bodies"]) if i is not None]
        mujoco.mj_forward(self._model, self._data)
        if not self._scene["joints"]:
            for place, body in moving:
                at = self._model.body_dofadr[place]
                self._data.qvel[at:at + 3] = body["velocity"]
                back = joint_tree.inverse(body["orientation"])
                self._data.qvel[at + 3:at + 6] = joint_tree.rotate(back, body["spin"])
        elif any(any(body["velocity"] + body["spin"]) for _, body in moving):
            # What all bodies do decides what joints do.
            rows = numpy.zeros((2 * len(moving), 3, self._model.nv))
            for n, (place, _) in enumerate(moving):
                mujoco.mj_jacBodyCom(self._model, self._data, rows[2 * n], rows[2 * n + 1], place)
            rows = rows.reshape(-1, self._model.nv)
            wanted = numpy.concatenate([body["velocity"] + body["spin"] for _, body in moving])
            self._data.qvel[:] = numpy.linalg.lstsq(rows, wanted, rcond=None)[0]
            if numpy.abs(rows @ self._data.qvel - wanted).max() > UNREACHED:
                raise Refused("velocities that joints do not allow")

    def step(self, size: float, count: int) -> None:
        self._model.opt.timestep = size
        mujoco.mj_step(self._model, self._data, nstep=count)
        if any(self._data.warning[alarm].number for alarm in ALARMS):
            raise ArithmeticError("unstable: it would go back to its beginning")

    def state(self) -> list[float]:
        # A step ends with new coordinates, and all else is of its beginning.
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        mujoco.mj_comVel(self._model, self._data)
        numbers: list[float] = []
        velocity = numpy.zeros(6)
        for place, body in zip(self._ids, self._scene["bodies"]):
            if place is None:
                numbers += [*body["position"], *body["orientation"], *[0.0] * 6]
                continue
            mujoco.mj_objectVelocity(self._model, self._data, mujoco.mjtObj.mjOBJ_BODY, place, velocity, 0)
            numbers += self._data.xpos[place].tolist() + self._data.xquat[place].tolist()
            numbers += velocity[3:].tolist() + velocity[:3].tolist()
        return numbers

    def hold(self, body: int, *wrench: float) -> None:
        self._data.xfrc_applied[self._ids[body]] = wrench

    def kick(self, body: int, *impulse: float) -> None:
        if self._scene["joints"]:
            raise Refused("impulses on what has joints")
        at = self._model.body_dofadr[self._ids[body]]
        self._data.qvel[at:at + 3] += numpy.array(impulse) / self._scene["bodies"][body]["mass"]

    def gravity(self, *gravity: float) -> None:
        self._model.opt.gravity = gravity


def main() -> None:
    # It would write its warnings to a file in the folder that this runs in; those that matter are counted.
    mujoco.set_mju_user_warning(lambda text: None)
    is_rk4 = sys.argv[1:] == ["--rk4"]
    serve("MuJoCo, RK4" if is_rk4 else "MuJoCo", mujoco.__version__,
          "double precision, coordinates of joints; "
          + ("integrator RK4 in place of Euler, all else default" if is_rk4 else "all defaults: integrator Euler")
          + ", pyramidal friction cone, Newton solver, soft contacts (solref 0.02 s, at least two steps; solimp 0.9 to "
          "0.95)", lambda scene: MujocoWorld(scene, is_rk4))


if __name__ == "__main__":
    main()

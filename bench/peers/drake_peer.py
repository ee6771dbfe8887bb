"""Drake as a peer: its multibody plant in discrete time."""

from __future__ import annotations

import importlib.metadata
from typing import Any

import numpy
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import Box, Capsule, Cylinder, HalfSpace, Sphere
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialForce, SpatialVelocity
from pydrake.multibody.plant import (AddMultibodyPlant, CoulombFriction, ExternallyAppliedSpatialForce,
                                     MultibodyPlantConfig)
from pydrake.multibody.tree import (BallRpyJoint, FixedOffsetFrame, JacobianWrtVariable, PrismaticJoint, RevoluteJoint,
                                    SpatialInertia, UnitInertia)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import joint_tree
from protocol import Refused, Scene, World, refuse_restitution, serve

UNREACHED = 1e-9
"""m/s or rad/s by which a velocity asked for may differ from the nearest that joints allow."""


def transform(pose: dict[str, Any]) -> RigidTransform:
    return RigidTransform(Quaternion(pose["orientation"]), pose["position"])


def shape_of(shape: dict[str, Any]) -> tuple[Any, RigidTransform]:
    """With its place in the body."""
    match shape["kind"]:
        case "sphere":
            return Sphere(shape["radius"]), RigidTransform()
        case "box":
            return Box(*(2 * each for each in shape["half_extents"])), RigidTransform()
        case "capsule":
            return Capsule(shape["radius"], 2 * shape["half_length"]), RigidTransform()
        case "cylinder":
            return Cylinder(shape["radius"], 2 * shape["half_length"]), RigidTransform()
        case "plane":
            normal = numpy.array(shape["normal"])
            return HalfSpace(), RigidTransform(RotationMatrix(Quaternion(joint_tree.upright(shape["normal"]))),
                                               shape["offset"] * normal)
        case other:
            # A mesh stands for its hull there, and so far no scene has a hull without restitution.
            raise Refused(f"shapes of the kind {other}")


class DrakeWorld(World):
    """Its plant is built for one step size, so that it is made when that is known: at the first step."""

    def __init__(self, scene: Scene) -> None:
        refuse_restitution(scene)
        self._scene = scene
        self._links = joint_tree.links(scene)
        self._held: dict[int, tuple[float, ...]] = {}
        self._size: float | None = None
        self._taken = 0

    def _build(self, size: float) -> None:
        builder = DiagramBuilder()
        self._plant, _ = AddMultibodyPlant(MultibodyPlantConfig(time_step=size), builder)
        self._plant.mutable_gravity_field().set_gravity_vector(self._scene["gravity"])
        self._bodies: dict[int, Any] = {}
        if self._scene["ground"]:
            self._give_shape(self._plant.world_body(), RigidTransform(), HalfSpace())
        for body in self._scene["bodies"]:
            if body["mass"] is None:
                shape, place = shape_of(body["shape"])
                self._give_shape(self._plant.world_body(), transform(body) @ place, shape)
        for link in self._links:
            self._give_body(link)
        self._plant.Finalize()
        diagram = builder.Build()
        self._simulator = Simulator(diagram)
        self._context = self._plant.GetMyMutableContextFromRoot(self._simulator.get_mutable_context())
        self._size = size
        for link in self._links:
            if link.joint is None:
                body = self._scene["bodies"][link.body]
                self._plant.SetFreeBodyPose(self._context, self._bodies[link.body], transform(body))
        self._give_velocities()
        self._apply_held()

    def _give_shape(self, body: Any, place: RigidTransform, shape: Any) -> None:
        friction = self._scene["friction"]
        name = f"shape {self._plant.num_collision_geometries()}"
        self._plant.RegisterCollisionGeometry(body, place, shape, name, CoulombFriction(friction, friction))

    def _give_body(self, link: joint_tree.Link) -> None:
        asked = self._scene["bodies"][link.body]
        unit = [each / asked["mass"] for each in asked["tensor"]]
        inertia = SpatialInertia(asked["mass"], numpy.zeros(3), UnitInertia(*unit))
        body = self._plant.AddRigidBody(f"body {link.body}", inertia)
        self._bodies[link.body] = body
        shape, place = shape_of(asked["shape"])
        self._give_shape(body, place, shape)
        if link.joint is None:
            return
        parent = self._plant.world_body() if link.parent is None else self._bodies[link.parent]
        near, far = (self._plant.AddFrame(FixedOffsetFrame(f"{end} {link.body}", on.body_frame(), transform(place)))
                     for end, on, place in (("near", parent, link.in_parent), ("far", body, link.in_body)))
        name = f"joint {link.body}"
        match link.joint["kind"]:
            case "ball":
                self._plant.AddJoint(BallRpyJoint(name, near, far))
            case "hinge":
                self._plant.AddJoint(RevoluteJoint(name, near, far, [0, 0, 1]))
            case "slider":
                self._plant.AddJoint(PrismaticJoint(name, near, far, [0, 0, 1]))

    def _give_velocities(self) -> None:
        asked = {place: self._scene["bodies"][place] for place in self._bodies}
        if not self._scene["joints"]:
            for place, body in asked.items():
                self._plant.SetFreeBodySpatialVelocity(
                    self._context, self._bodies[place], SpatialVelocity(body["spin"], body["velocity"]))
        elif any(any(body["velocity"] + body["spin"]) for body in asked.values()):
            # What all bodies do decides what joints do.
            world = self._plant.world_frame()
            rows = numpy.concatenate([self._plant.CalcJacobianSpatialVelocity(
                self._context, JacobianWrtVariable.kV, self._bodies[place].body_frame(), [0, 0, 0], world, world)
                for place in asked])
            wanted = numpy.concatenate([body["spin"] + body["velocity"] for body in asked.values()])
            rates = numpy.linalg.lstsq(rows, wanted, rcond=None)[0]
            if numpy.abs(rows @ rates - wanted).max() > UNREACHED:
                raise Refused("velocities that joints do not allow")
            self._plant.SetVelocities(self._context, rates)

    def _apply_held(self) -> None:
        forces = []
        for body, wrench in self._held.items():
            force = ExternallyAppliedSpatialForce()
            force.body_index = self._bodies[body].index()
            force.F_Bq_W = SpatialForce(list(wrench[3:]), list(wrench[:3]))
            forces.append(force)
        if forces:
            self._plant.get_applied_spatial_force_input_port().FixValue(self._context, forces)

    def step(self, size: float, count: int) -> None:
        if self._size is None:
            self._build(size)
        if size != self._size:
            raise Refused("steps of changing size in discrete time")
        self._taken += count
        try:
            self._simulator.AdvanceTo(self._taken * size)
        except RuntimeError as error:
            # The texts count objects of the process: no two are the same.
            raise ArithmeticError("unstable: poses are no numbers, or no solution is found") from error

    def state(self) -> list[float]:
        numbers: list[float] = []
        for place, body in enumerate(self._scene["bodies"]):
            if body["mass"] is None or self._size is None:
                numbers += [*body["position"], *body["orientation"], *body["velocity"], *body["spin"]]
                continue
            pose = self._plant.EvalBodyPoseInWorld(self._context, self._bodies[place])
            velocity = self._plant.EvalBodySpatialVelocityInWorld(self._context, self._bodies[place])
            numbers += pose.translation().tolist() + pose.rotation().ToQuaternion().wxyz().tolist()
            numbers += velocity.translational().tolist() + velocity.rotational().tolist()
        return numbers

    def hold(self, body: int, *wrench: float) -> None:
        self._held[body] = wrench
        if self._size is not None:
            self._apply_held()


if __name__ == "__main__":
    serve("Drake", importlib.metadata.version("drake"),
          "double precision, coordinates of joints (balls by roll, pitch and yaw); discrete time, all defaults: lagged "
          "contact approximation (SAP solver), point contact with one point for a pair, so that what lies on a face "
          "rocks (for this its manual has hydroelastic contact, with a modulus to choose for each body)", DrakeWorld)

"""Joints against a real server."""

import math

import genphys
import numpy as np
import pytest
from genphys import joints


def pendulum(world, **keywords):
    ball = world.add_sphere(radius=0.1, mass=1.0, position=(0, 0, 4))
    return ball, world.join(None, ball, joints.Hinge(**keywords), frame_in_a=(0, 0, 5))


def test_a_motor_turns_a_hinge_and_the_frame_tells_how_far(world):
    wheel = world.add_sphere(mass=1.0, position=(0, 0, 5))
    joint = world.join(None, wheel, joints.Hinge(motor=joints.Motor(velocity=3.0)))
    frame = world.step(240, frame=genphys.FrameRequest(joints=True))
    assert frame.joint_ids.tolist() == [joint.id]
    assert frame.joint_positions[0, 5] == pytest.approx(3.0, abs=1e-5)
    assert frame.joint_rates[0, 5] == pytest.approx(3.0, abs=1e-5)
    assert frame.joint_forces[0, 2] == pytest.approx(9.81, rel=1e-5)


def test_many_motors_are_set_in_columns(world):
    driven = joints.Hinge(motor=joints.Motor())
    wheels = [world.add_sphere(mass=1.0, position=(2 * i, 0, 5)) for i in range(3)]
    handles = [world.join(None, wheel, driven) for wheel in wheels]
    world.set_motors(handles, np.array([1.0, 2.0, 3.0]))
    frame = world.step(1, frame=genphys.FrameRequest(joints=True))
    assert frame.joint_rates[:, 5] == pytest.approx([1.0, 2.0, 3.0], abs=1e-5)


def test_a_batch_joins_what_it_creates(world):
    with world.batch() as first:
        first.set_gravity((0, 0, -9.81))
    with world.batch() as batch:
        upper = batch.add_sphere(radius=0.1, position=(0, 0, 4))
        lower = batch.add_sphere(radius=0.1, position=(0, 0, 3))
        rope = batch.join(upper, lower, joints.Distance(upper=1.0))
        batch.join(None, upper, joints.Ball(), frame_in_a=(0, 0, 5))
    world.step(120)
    info = world.joints()[0]
    assert (info.id, info.entity_a, info.entity_b) == (rope.id, upper.id, lower.id)
    assert info.kind == joints.Distance(upper=1.0)
    assert info.force[2] > 0


@pytest.mark.parametrize(
    "kind",
    [
        joints.Ball(swing_max=0.5, twist_lower=-0.1, twist_upper=0.2),
        joints.Hinge(lower=-1.0, upper=1.0, spring=joints.Spring(stiffness=5.0, damping=1.0, rest=0.1)),
        joints.Slider(motor=joints.Motor(position=0.5, velocity=0.1, stiffness=9.0, damping=2.0, force_max=7.0)),
        joints.Universal(about_x=joints.Axis(upper=0.5), about_y=joints.Axis(lower=-0.5)),
        joints.Fixed(),
        joints.Wheel(suspension=joints.Axis(lower=-0.1, upper=0.1), spin=joints.Axis(motor=joints.Motor(velocity=2.0))),
        joints.SixDof(along_x=joints.Axis(), about_z=joints.Axis(upper=2.0)),
        joints.Distance(lower=0.5, upper=1.5),
    ],
)
def test_every_kind_travels_there_and_back(world, kind):
    ball = world.add_sphere(mass=1.0, position=(0, 0, 5))
    joint = world.join(None, ball, kind, frame_in_a=((0, 0, 5), (1, 0, 0, 0)), break_force=1e6, collide_connected=True)
    info = world.joints()[0]
    assert info.joint == joint
    assert info.kind == kind
    assert (info.break_force, info.break_torque, info.collide_connected) == (1e6, None, True)


def test_a_joint_changes_its_kind_and_goes(world):
    ball, joint = pendulum(world)
    world.change_joint(joint, joints.Gear(ratio=2.0))
    assert world.joints()[0].kind == joints.Gear(ratio=2.0)
    world.remove_joint(joint)
    assert world.joints() == []
    with pytest.raises(genphys.StaleIdError):
        world.remove_joint(joint)


def test_what_is_not_named_of_a_changed_joint_stays(world):
    ball = world.add_sphere(mass=1.0, position=(0, 0, 5))
    kind = joints.Hinge(upper=1.0)
    joint = world.join(None, ball, kind, break_force=1e6, break_torque=1e5)

    world.change_joint(joint, collide_connected=True, break_force=2e6)
    info = world.joints()[0]
    assert (info.kind, info.break_force, info.break_torque, info.collide_connected) == (kind, 2e6, 1e5, True)

    world.change_joint(joint, joints.Hinge(upper=0.5), break_force=math.inf)
    info = world.joints()[0]
    assert info.kind == joints.Hinge(upper=0.5)
    assert (info.break_force, info.break_torque, info.collide_connected) == (None, 1e5, True)

    with pytest.raises(genphys.OutOfRangeError) as refused:
        world.change_joint(joint, break_torque=-1.0)
    assert refused.value.field == "commands[0].update_joint.joint.break_torque"
    assert world.joints()[0].break_torque == 1e5


def test_a_joint_that_breaks_tells_what_it_held(world):
    ball = world.add_sphere(radius=0.1, mass=2.0, position=(0, 0, 4))
    joint = world.join(None, ball, joints.Ball(), frame_in_a=(0, 0, 5), frame_in_b=(0, 0, 1), break_force=10.0)
    broken = [event for event in world.step(2).events if isinstance(event, genphys.JointBroke)]
    assert [event.joint for event in broken] == [joint.id]
    assert broken[0].force == pytest.approx(2 * 9.81, rel=1e-5)


def test_what_is_no_kind_is_refused_before_it_is_sent(world):
    ball = world.add_sphere()
    with pytest.raises(TypeError, match=r"kind is 'hinge', not one of: genphys.joints.Ball\(...\), genphys.joints.Hinge"):
        world.join(None, ball, "hinge")
    with pytest.raises(genphys.InvalidValueError, match="itself"):
        world.join(ball, ball, joints.Fixed())
    with pytest.raises(genphys.OutOfRangeError) as refused:
        world.join(None, ball, joints.Ball(swing_max=math.tau))
    assert refused.value.field.endswith("ball.swing_max_radians")

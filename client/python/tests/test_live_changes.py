"""What changes while a world runs, against a real server."""

import genphys
import pytest
from genphys import fields, joints


def of(events, kind):
    return [event for event in events if isinstance(event, kind)]


def test_a_belt_carries_and_a_locked_crate_stays(world):
    world.add_box(
        half_extents=(10, 10, 0.5),
        motion="static",
        position=(0, 0, 0.5),
        surface_velocity=(2, 0, 0),
    )
    crate = world.add_box(mass=1.0, position=(0, 0, 1.5))
    held = world.add_box(
        mass=1.0, position=(0, 5, 1.5), locked_axes=genphys.LockedAxes(linear_x=True, angular_z=True)
    )
    frame = world.step(240)
    assert frame.linear_velocities[frame.row(crate)] == pytest.approx([2, 0, 0], abs=0.01)
    assert frame.positions[frame.row(held)][0] == 0
    assert world.entity(held).locked_axes == genphys.LockedAxes(linear_x=True, angular_z=True)


def test_a_pusher_is_led_step_by_step(world):
    crate = world.add_box(mass=1.0, position=(0, 0, 0.5))
    pusher = world.add_box(half_extents=(0.1, 1, 0.5), motion="kinematic", position=(-0.6, 0, 0.55))
    step = 1 / 60
    for i in range(60):
        world.set_pose(pusher, position=(-0.6 + (i + 1) * step, 0, 0.55), over_steps=1)
        frame = world.step()
    assert frame.positions[frame.row(crate)][0] == pytest.approx(1, abs=2e-3)
    with pytest.raises(genphys.InvalidValueError, match="kinematic") as refused:
        world.set_pose(crate, position=(0, 0, 1), over_steps=3)
    assert refused.value.field.endswith("set_pose.over_steps")


def test_two_entities_ignore_each_other(world):
    shelf = world.add_box(half_extents=(2, 2, 0.1), motion="static", position=(0, 0, 2))
    falls = world.add_sphere(mass=1.0, position=(-1, 0, 4), ignored_entities=[shelf])
    stays = world.add_sphere(mass=1.0, position=(1, 0, 4))
    frame = world.step(240)
    assert frame.positions[frame.row(falls)][2] == pytest.approx(0.5, abs=1e-3)
    assert frame.positions[frame.row(stays)][2] == pytest.approx(2.6, abs=1e-3)
    assert world.entity(falls).ignored_entities == (shelf.id,)
    world.update_entity(stays, ignored_entities=[shelf])
    frame = world.step(240)
    assert frame.positions[frame.row(stays)][2] == pytest.approx(0.5, abs=1e-3)
    world.update_entity(stays, clear=["rigid_body.ignored_entity_ids"])
    assert world.entity(stays).ignored_entities == ()


def test_corrections_travel_both_ways(server):
    policy = genphys.ErrorCorrection(time_constant=0.1, slop=0.01)
    with server.create_world(error_correction=policy) as world:
        ball = world.add_sphere(error_correction=genphys.ErrorCorrection(correction_speed_max=0.5))
        assert world.entity(ball).error_correction == genphys.ErrorCorrection(
            time_constant=0.1, correction_speed_max=0.5, slop=0.01
        )


def test_an_entity_changes_part_by_part(world):
    crate = world.add_box(mass=2.0, position=(0, 0, 5), name="crate")
    world.update_entity(crate, motion="static", name="wall")
    world.step(10)
    info = world.entity(crate)
    assert (info.motion, info.name, info.mass, info.position) == ("static", "wall", 2.0, (0, 0, 5))

    (box,) = info.geometries
    lid = genphys.Geometry(shape=genphys.Sphere(0.2), position=(0, 0, 1), id=9)
    world.update_entity(crate, motion="dynamic", geometries=[box, lid])
    assert [each.id for each in world.entity(crate).geometries] == [box.id, 9]
    world.update_entity(crate, clear=["rigid_body.inertia"], visual=genphys.Visual(uri="crate.glb"))
    assert world.entity(crate).mass is None and world.entity(crate).visual.uri == "crate.glb"
    world.update_entity(crate, physics=False, clear=["visual"])
    assert not world.entity(crate).physics and world.entity(crate).visual is None
    world.update_entity(crate, physics=True, geometries=[genphys.Geometry(shape=genphys.Sphere(0.5))])
    assert world.entity(crate).physics
    with pytest.raises(TypeError, match="colour"):
        world.update_entity(crate, colour="red")


def test_half_a_pose_changes_and_the_other_half_stays(world):
    turned, turned_back = (0.6, 0, 0, 0.8), (1, 0, 0, 0)
    crate = world.add_box(mass=1.0, position=(3, 0, 5), orientation=turned)
    world.update_entity(crate, position=(4, 0, 5))
    assert (world.entity(crate).position, world.entity(crate).orientation) == ((4, 0, 5), turned)
    world.update_entity(crate, orientation=turned_back, name="wall")
    info = world.entity(crate)
    assert (info.position, info.orientation, info.name) == ((4, 0, 5), turned_back, "wall")
    world.update_entity(crate, position=None, motion="static")
    assert world.entity(crate).position == (4, 0, 5)
    with pytest.raises(genphys.OutOfRangeError):
        world.update_entity(crate, position=(1e30, 0, 0), name="crate")
    assert world.entity(crate).name == "wall"  # both or none


def test_an_entity_is_not_removed_by_a_joint_of_its_number(world):
    ball = world.add_sphere(mass=1.0, position=(0, 0, 5))
    joint = world.join(None, ball, joints.Fixed())
    assert joint.id == world.entities()[0].id
    with pytest.raises(TypeError, match="expected an Entity or its id, not Joint"):
        world.remove(joint)
    assert len(world.entities()) == 2
    world.remove_joint(world.joints()[0])
    assert world.joints() == []


def test_joints_and_fields_are_told_of(space):
    a, b = space.add_sphere(mass=1.0), space.add_sphere(mass=1.0, position=(3, 0, 0))
    with space.batch() as batch:
        joint = batch.join(a, b, joints.Fixed())
        spring = batch.add_field(fields.Spring(a=a, b=b, stiffness=5.0))
        push = batch.add_field(fields.Uniform(force=(0, 0, 1)), entities=[a], region=((-9, -9, -9), (9, 9, 9)))
    events = space.step(1).events
    (made,) = of(events, genphys.JointCreated)
    assert (made.joint, made.entity_a, made.entity_b, made.description) == (joint.id, a, b, joints.Fixed())
    assert made.involves(a) and not made.involves(999)
    assert sorted(each.field for each in of(events, genphys.ForceFieldCreated)) == [spring.id, push.id]
    first, second = space.fields()
    assert first.field == fields.Spring(a=a.id, b=b.id, stiffness=5.0)
    assert (second.id, second.entities, second.region) == (push.id, (a.id,), ((-9, -9, -9), (9, 9, 9)))

    with space.batch() as batch:
        batch.remove(a)
    gone = space.step(0).events
    assert [each.joint for each in of(gone, genphys.JointDeleted)] == [joint.id]
    assert sorted(each.field for each in of(gone, genphys.ForceFieldDeleted)) == [spring.id, push.id]


def test_a_batch_pushes_what_it_creates(space):
    with space.batch() as first:
        first.set_gravity((0, 0, 0))
    with space.batch() as batch:
        batch.add_sphere(mass=1.0, position=(9, 0, 0))
        pushed = batch.add_sphere(mass=1.0)
        other = batch.add_sphere(mass=1.0, position=(0, 4, 0))
        batch.add_field(fields.Uniform(acceleration=(0, 0, 1)), entities=[pushed])
        batch.add_field(fields.Spring(a=pushed, b=other, stiffness=10.0, rest_length=1.0))
    frame = space.step(1)
    assert frame.linear_velocities[frame.row(pushed)][2] > 0
    assert frame.linear_velocities[frame.row(pushed)][1] > 0 > frame.linear_velocities[frame.row(other)][1]
    assert (abs(frame.linear_velocities[:, 2]) > 1e-3).sum() == 1  # what the spring tilts is far less


def test_a_broken_joint_names_its_sides(world):
    ball = world.add_sphere(mass=1.0, position=(0, 0, 5))
    world.join(None, ball, joints.Fixed(), break_force=1.0)
    (broken,) = of(world.step(2).events, genphys.JointBroke)
    assert broken.entity_a is None and broken.entity_b == ball

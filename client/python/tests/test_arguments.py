"""What has no meaning is refused before it is sent, by the name of the argument, and costs no collected command."""

import math
import re

import numpy as np
import pytest
from fake_server import FakeServer, answer_step, last_command

import genphys
from genphys import fields, joints
from genphys._contract import wire
from genphys.queries import _many

ENTITY, JOINT, FIELD = genphys.Entity(5), joints.Joint(5), fields.ForceField(5)
GEOMETRY = genphys.Geometry(shape=genphys.Sphere(1))


@pytest.fixture
def fake():
    def answer_frames(request, context):
        yield wire.WatchFramesResponse()

    with FakeServer(Step=answer_step, WatchFrames=answer_frames) as server:
        yield server


@pytest.fixture
def client(fake):
    with genphys.connect(fake.address) as connected:
        yield connected


@pytest.fixture
def world(client):
    return client.world("lab")


ASKS_FOR_ENTITIES = [
    lambda world, it: world.remove(it),
    lambda world, it: world.entity(it),
    lambda world, it: world.contacts_of(it),
    lambda world, it: world.apply_force(it, (1, 0, 0)),
    lambda world, it: world.apply_impulse(it, (1, 0, 0)),
    lambda world, it: world.apply_forces([it], [(1, 0, 0)]),
    lambda world, it: world.apply_forces(np.array([it], object), [(1, 0, 0)]),
    lambda world, it: world.set_pose(it, position=(1, 0, 0)),
    lambda world, it: world.set_velocity(it, linear=(1, 0, 0)),
    lambda world, it: world.update_entity(it, mass=1.0),
    lambda world, it: world.add_box(ignored_entities=[it]),
    lambda world, it: world.join(it, None, joints.Ball()),
    lambda world, it: world.add_field(fields.Drag(), entities=[it]),
    lambda world, it: world.add_field(fields.Spring(a=it)),
    lambda world, it: world.distances([1], [it]),
    lambda world, it: world.step(frame=genphys.FrameRequest(entities=[it])),
    lambda world, it: world.step(events=genphys.EventFilter(entities=[it])),
    lambda world, it: world.step().row(it),
    lambda world, it: genphys.EntitySlept(1, 1, ENTITY).involves(it),
]


@pytest.mark.parametrize("ask", ASKS_FOR_ENTITIES)
def test_only_an_entity_stands_for_an_entity(world, ask):
    for other in (JOINT, FIELD):
        with pytest.raises(TypeError, match=f"expected an Entity or its id, not {type(other).__name__}"):
            ask(world, other)
    for other in (True, np.True_, 5.0, "5"):
        with pytest.raises(TypeError, match="expected an Entity or its id, not "):
            ask(world, other)
    with pytest.raises(ValueError, match="-1 is no id"):
        ask(world, -1)


def test_only_a_joint_stands_for_a_joint_and_only_a_field_for_a_field(world, fake):
    for other in (ENTITY, FIELD, True):
        for ask in (world.remove_joint, world.change_joint, lambda it: world.set_motors([it], [1.0])):
            with pytest.raises(TypeError, match=f"expected a Joint or its id, not {type(other).__name__}"):
                ask(other)
    for other in (ENTITY, JOINT, True):
        for ask in (world.remove_field, lambda it: world.update_field(it, fields.Drag())):
            with pytest.raises(TypeError, match=f"expected a ForceField or its id, not {type(other).__name__}"):
                ask(other)
    assert fake.received("Step") == []

    world.remove_joint(JOINT)
    assert last_command(fake).delete_joint.joint_id == 5
    world.remove_field(np.uint64(5))
    assert last_command(fake).delete_force_field.field_id == 5


def test_handles_of_fields_are_equal_when_their_ids_are():
    new = fields.ForceField()

    assert FIELD == fields.ForceField(5) != fields.ForceField(6)
    assert new == new != fields.ForceField()
    assert FIELD != ENTITY and FIELD != JOINT
    assert len({FIELD, fields.ForceField(5), fields.ForceField(6)}) == 2


WRONG_KINDS = {
    "kind is <class 'genphys.joints.Hinge'>, not one of: genphys.joints.Ball(...), ": lambda world: world.join(
        5, None, joints.Hinge
    ),
    "field is 'drag', not one of: genphys.fields.Uniform(...), ": lambda world: world.add_field("drag"),
    "shape is 'ball', not one of: genphys.Sphere(...), ": lambda world: world.cast_shape("ball", (0, 0, 0), (0, 0, 1)),
    "unexpected keyword argument 'possition': did you mean 'position'?": lambda world: world.add_box(possition=1),
    "unexpected keyword argument 'x': help(genphys.World.add_box) lists": lambda world: world.add_box(x=1),
    "unexpected keyword argument 'physics'": lambda world: world.add_box(physics=False),
    "update_entity() got an unexpected keyword argument 'radius'": lambda world: world.update_entity(5, radius=1),
    "friction is of a geometry: give all of these, as geometries=[genphys.Geometry(friction=...)]": lambda world: (
        world.update_entity(5, friction=0.5)
    ),
    "frame_in_a is (0, 0), not a position or (position, orientation)": lambda world: world.join(
        5, None, joints.Ball(), frame_in_a=(0, 0)
    ),
    "filter is EventKinds(": lambda world: world.events(genphys.EventKinds()),
    "forces is [(None, 0, 0)], not an array of numbers": lambda world: world.apply_forces([5], [(None, 0, 0)]),
    "origins is array(": lambda world: world.cast_rays(None, (0, 0, 1)),
    "motion is None, not one of": lambda world: world.add_box(motion=None),
    "motion is 1, not one of": lambda world: world.add_box(motion=1),
    "coordinates is None, not one of": lambda world: world.apply_force(5, (1, 0, 0), coordinates=None),
    "engine is None, not a str": lambda world: world.set_engine(None),
    "auto_disable is False, not genphys.AutoDisable": lambda world: world.add_box(auto_disable=False),
    "error_correction is 1, not genphys.ErrorCorrection": lambda world: world.add_box(error_correction=1),
    "visual is 'x.glb', not genphys.Visual": lambda world: world.add_box(visual="x.glb"),
    "locked_axes is ['linear_x'], not genphys.LockedAxes": lambda world: world.add_box(locked_axes=["linear_x"]),
    "geometries[1] is Sphere(radius=1), not genphys.Geometry": lambda world: world.add_entity(
        geometries=[GEOMETRY, genphys.Sphere(1)]
    ),
    "geometries[0] is Sphere(radius=1), not genphys.Geometry": lambda world: world.update_entity(
        5, geometries=[genphys.Sphere(1)]
    ),
    "geometries is Geometry(": lambda world: world.add_entity(geometries=GEOMETRY),
    "frame is 'poses', not True, False or genphys.FrameRequest": lambda world: world.step(frame="poses"),
    "frame is 1, not True, False or genphys.FrameRequest": lambda world: world.step(frame=1),
    "events is EventKinds(": lambda world: world.step(events=genphys.EventKinds()),
    "kinds is True, not genphys.EventKinds": lambda world: world.step(events=genphys.EventFilter(kinds=True)),
    "dtype is None, not one of: float32, float64": lambda world: world.step(frame=genphys.FrameRequest(dtype=None)),
    "steps is 1.5, not a whole number": lambda world: world.step(1.5),
    "step_size is 'a', not a number": lambda world: world.step(step_size="a"),
    "radius is 'a', not a number": lambda world: world.add_sphere(radius="a"),
    "name is 3, not a str": lambda world: world.add_sphere(name=3),
    "timeout is '1', not a number of seconds": lambda world: world.step(timeout="1"),
    "gravity is -9.8, not 3 numbers": lambda world: world.set_gravity(-9.8),
    "half_extents is 1, not 3 numbers": lambda world: world.add_box(half_extents=1),
    "force is 5, not 3 numbers": lambda world: world.apply_force(5, 5),
    "force is '123', not 3 numbers": lambda world: world.apply_force(5, "123"),
    "force is ('1', '2', '3'), not 3 numbers": lambda world: world.apply_force(5, ("1", "2", "3")),
    "force is (1, None, 0), not 3 numbers": lambda world: world.apply_force(5, (1, None, 0)),
    "force is {1, 2, 3}, not 3 numbers": lambda world: world.apply_force(5, {1, 2, 3}),
    "force is {1: 2, 2: 3, 3: 4}, not 3 numbers": lambda world: world.apply_force(5, {1: 2, 2: 3, 3: 4}),
    "forces is [('1', '2', '3')], not an array of numbers": lambda world: world.apply_forces([5], [("1", "2", "3")]),
    "entities is <entity 5>, not a list": lambda world: world.apply_forces(ENTITY, [(1, 0, 0)]),
    "entities is a set": lambda world: world.apply_forces({5, 6}, [(1, 0, 0), (0, 1, 0)]),
    "clear is 'visual', not a list": lambda world: world.update_entity(5, clear="visual"),
    "frame_in_a is 3, not a position or (position, orientation)": lambda world: world.join(
        5, None, joints.Ball(), frame_in_a=3
    ),
    "motor is 3, not genphys.joints.Motor": lambda world: world.join(5, None, joints.Hinge(motor=3)),
    "velocity is 'a', not a number": lambda world: world.join(5, None, joints.Hinge(motor=joints.Motor(velocity="a"))),
    "drag is 3, not genphys.fields.Drag": lambda world: world.add_field(fields.Buoyancy(drag=3)),
    "add_box() got an unexpected keyword argument 'half_extent'": lambda world: world.add_box(half_extent=(1, 1, 1)),
    "add_entity() got an unexpected keyword argument 'radius'": lambda world: world.add_entity(radius=1),
}


@pytest.mark.parametrize("told", WRONG_KINDS)
def test_what_is_of_another_kind_is_a_type_error_that_names_the_argument(world, fake, told):
    with pytest.raises(TypeError, match=re.escape(told)):
        WRONG_KINDS[told](world)

    assert fake.received("Step") == fake.received("CreateEntity") == []


NO_EFFECT = {
    "mass has no effect here: add_plane makes what nothing pushes": lambda world: world.add_plane(mass=1.0),
    "density has no effect here": lambda world: world.add_mesh(TRIANGLE, [(0, 1, 2)], density=1.0),
    "gravity_scale has no effect here": lambda world: world.add_heightfield(
        np.zeros((2, 2)), motion="kinematic", gravity_scale=0.5
    ),
    "mass has no effect here: physics=False": lambda world: world.add_entity(physics=False, mass=1.0),
    "geometries has no effect here": lambda world: world.add_entity(physics=False, geometries=[GEOMETRY]),
    "linear_velocity has no effect here: physics=False takes": lambda world: world.update_entity(
        5, physics=False, linear_velocity=(0, 0, 1)
    ),
    "point has no effect here: it is where force acts": lambda world: world.apply_force(
        5, torque=(0, 0, 1), point=(0, 0, 1)
    ),
    "point has no effect here: it is where linear acts": lambda world: world.apply_impulse(
        5, angular=(0, 0, 1), point=(0, 0, 1)
    ),
    "give force or torque": lambda world: world.apply_force(5),
    "give linear or angular": lambda world: world.apply_impulse(5, coordinates="entity"),
    "give forces, torques or both": lambda world: world.apply_forces([5]),
    "entities has no effect here: a spring acts on its a and b": lambda world: world.add_field(SPRING, entities=[6]),
    "region has no effect here": lambda world: world.update_field(7, SPRING, region=((0, 0, 0), (1, 1, 1))),
}
TRIANGLE = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
SPRING = fields.Spring(a=5, stiffness=1.0)


@pytest.mark.parametrize("told", NO_EFFECT)
def test_what_would_be_left_out_in_silence_is_refused(world, fake, told):
    with pytest.raises(ValueError, match=re.escape(told)):
        NO_EFFECT[told](world)

    assert fake.received("Step") == fake.received("CreateEntity") == []


def test_what_has_an_effect_beside_these_is_taken(world, fake):
    with world.batch() as batch:
        batch.add_plane(friction=0.5, name="floor", mass=None)
        batch.add_mesh(TRIANGLE, [(0, 1, 2)], motion="dynamic", mass=1.0)
        batch.add_box(motion="static", mass=1.0)
        batch.add_entity(physics=False, position=(0, 0, 1), geometries=[])
        batch.update_entity(5, physics=False, name="ghost")
        batch.apply_force(5, (1, 0, 0), torque=(0, 0, 1), point=(0, 0, 1))
        batch.apply_impulse(5, angular=(0, 0, 1))
        batch.apply_forces([5], torques=[(0, 0, 1)])
        batch.add_field(SPRING)
    world.step()

    assert len(fake.received("Step")[-1].commands) == 9


def test_what_an_update_takes_away_is_named_as_what_it_gives(world, fake):
    world.update_entity(5, clear=["mass", "ignored_entities", "physics", "name"])
    paths = ["rigid_body.inertia", "rigid_body.ignored_entity_ids", "rigid_body", "display_name"]
    assert list(last_command(fake).update_entity.update_mask.paths) == paths
    world.update_entity(5, clear=paths)
    assert list(last_command(fake).update_entity.update_mask.paths) == paths

    with pytest.raises(ValueError, match="clear has 'color', not one of: angular_damping, .*mass, motion, name"):
        world.update_entity(5, clear=["color"])


def test_an_empty_list_has_no_rows_and_one_vector_is_one():
    assert _many([]).shape == _many(np.zeros((0, 3))).shape == (0, 3)
    assert _many([], 4).shape == (0, 4)
    assert _many([1, 2]).shape == (1, 2)


WRONG_VALUES = {
    "orientations has shape (1, 3), not (n, 4)": lambda world: world.find_overlaps(
        genphys.Sphere(), (0, 0, 1), orientations=(1, 0, 0)
    ),
    "orientations has 2 rows, not 1 or 3, as many as positions": lambda world: world.find_overlaps(
        genphys.Sphere(), np.zeros((3, 3)), orientations=np.zeros((2, 4))
    ),
    "after is -1, not a whole number": lambda world: world.events(after=(3, -1)),
    "steps is -1, not a whole number from 0 to 4294967295": lambda world: world.step(-1),
    "expected_step is -1, not a whole number": lambda world: world.step(expected_step=-1),
    "over_steps is -1, not a whole number": lambda world: world.set_pose(5, position=(1, 0, 0), over_steps=-1),
    "every is -1, not a whole number": lambda world: world.frames(every=-1),
    "category_bits is -1, not a whole number": lambda world: world.add_box(category_bits=-1),
    "indices is [0, 1, -1], not a list, each a whole number": lambda world: world.add_mesh(
        [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, -1)]
    ),
    "dtype is 'f4', not one of: float32, float64": lambda world: world.step(frame=genphys.FrameRequest(dtype="f4")),
    "dtype is 'fixed64', not one of": lambda world: world.step(frame=genphys.FrameRequest(dtype="fixed64")),
    "timeout is nan": lambda world: world.step(timeout=math.nan),
    "duration is nan": lambda world: world.frames(duration=math.nan),
    "force has shape (1, 3), not (3,)": lambda world: world.apply_force(5, np.zeros((1, 3))),
    "forces has shape (2,), not (n, 3)": lambda world: world.apply_forces([5], [1, 2]),
    "forces is [(1, 2, 3), (1, 2)], not an array": lambda world: world.apply_forces([5, 6], [(1, 2, 3), (1, 2)]),
    "entities has shape (1, 2), not (n,)": lambda world: world.apply_forces(np.array([[5, 6]]), np.zeros((2, 3))),
    "entities has -1, which is no id": lambda world: world.apply_forces(np.array([5, -1]), np.zeros((2, 3))),
    "forces has rows, but nobody is named": lambda world: world.apply_forces([], [(1, 0, 0)]),
    "velocities has shape (), not (n,)": lambda world: world.set_motors([JOINT], 1.0),
    "velocities has shape (1, 1), not (n,)": lambda world: world.set_motors([JOINT], [[1.0]]),
    "region is (1, 2, 3), not two opposite corners": lambda world: world.add_field(fields.Drag(), region=(1, 2, 3)),
}


@pytest.mark.parametrize("told", WRONG_VALUES)
def test_what_nothing_can_be_is_a_value_error_that_names_the_argument(world, fake, told):
    with pytest.raises(ValueError, match=re.escape(told)):
        WRONG_VALUES[told](world)

    assert fake.received("Step") == fake.received("CreateEntity") == []


def test_worlds_are_described_by_arguments_of_their_kinds(client):
    for told, arguments in {
        "name is 3, not a str": {"name": 3},
        "gravity is -9.8, not 3 numbers": {"gravity": -9.8},
        "recorded_events is True, not genphys.EventKinds": {"recorded_events": True},
        "required_features is 'shape_box', not a list": {"required_features": "shape_box"},
    }.items():
        with pytest.raises(TypeError, match=re.escape(told)):
            client.create_world(**arguments)
    with pytest.raises(TypeError, match=re.escape("worlds[0] is 'lab', not genphys.World")):
        client.step_worlds(["lab"])


def test_numbers_of_a_frame_are_named_as_numpy_names_them(world, fake):
    for dtype in ("float32", np.float32, np.dtype("float32")):
        world.step(frame=genphys.FrameRequest(dtype=dtype))
    world.step(frame=genphys.FrameRequest(dtype=float))

    *single, double = (request.frame.scalar for request in fake.received("Step"))
    assert len(set(single)) == 1 and double not in single


def test_columns_of_nothing_do_nothing(world, fake):
    world.apply_forces([], [])
    world.apply_forces(np.array([], np.uint64), np.zeros((0, 3)), torques=[])
    world.set_motors([], [])

    assert fake.received("Step") == []


BAD_STEPS = [
    {"steps": -1},
    {"steps": 1.5},
    {"frame": "poses"},
    {"events": genphys.EventKinds()},
    {"step_size": "a"},
]


@pytest.mark.parametrize("arguments", BAD_STEPS)
def test_a_bad_argument_does_not_cost_what_was_collected(client, world, arguments):
    other = client.world("other")
    with world.batch() as batch:
        ball = batch.add_sphere()
    with world.drive() as drive:
        for step in (world.step, drive.send, lambda **bad: client.step_worlds([world, other], **bad)):
            with pytest.raises((TypeError, ValueError)):
                step(**arguments)
        assert drive.in_flight == 0
    with pytest.raises(TypeError):
        client.step_worlds([world, "other"])
    for step in (world.step, lambda **bad: client.step_worlds([world], **bad)):
        with pytest.raises(ValueError, match="timeout"):
            step(timeout=math.nan)

    assert world.step().created == (ball,)


def test_a_batch_takes_nothing_after_its_block(world, fake):
    with world.batch() as batch:
        batch.set_gravity((0, 0, 0))
    with pytest.raises(ZeroDivisionError), world.batch() as dropped:
        1 / 0  # noqa: B018

    for late in (batch, dropped):
        with pytest.raises(ValueError, match="the block of this batch has ended"):
            late.add_sphere()
        with pytest.raises(ValueError, match="the block of this batch has ended"):
            late.join(5, None, joints.Ball())

    world.step()
    assert last_command(fake).HasField("set_gravity")


def test_an_entity_of_another_open_batch_cannot_be_named_yet(world):
    with world.batch() as outer:
        ball = outer.add_sphere()
        with world.batch() as inner, pytest.raises(ValueError, match="a new entity is not created before the next"):
            inner.join(ball, None, joints.Ball())


def test_half_a_pose_leaves_the_other_half(world, fake):
    world.update_entity(5, position=(1, 2, 3))
    half = last_command(fake).set_pose
    assert (half.entity_id, half.pose.position.z, half.pose.HasField("orientation")) == (5, 3, False)

    world.update_entity(5, orientation=(0, 1, 0, 0), position=None, mass=2.0)
    update, half = fake.received("Step")[-1].commands
    assert list(update.update_entity.update_mask.paths) == ["rigid_body.inertia"]
    assert (half.set_pose.pose.orientation.x, half.set_pose.pose.HasField("position")) == (1, False)

    world.update_entity(5, position=(1, 2, 3), orientation=(0, 1, 0, 0))
    update = last_command(fake).update_entity
    assert list(update.update_mask.paths) == ["pose"]
    assert (update.entity.pose.position.z, update.entity.pose.orientation.x) == (3, 1)

    world.update_entity(5, position=None, orientation=None, name="crate")
    assert list(last_command(fake).update_entity.update_mask.paths) == ["display_name"]


def test_what_is_no_address_and_no_position_is_refused_by_its_name(world):
    with pytest.raises(TypeError, match="address is 50051, not a text, as in"):
        genphys.connect(50051)
    with pytest.raises(ValueError, match='address is empty: it is a text as in "127.0.0.1:50051"'):
        genphys.connect("")
    for wrong in (3, (1, 2, 3), "12", (1, "2")):
        with pytest.raises(TypeError, match=r"after is .*, not a position \(epoch, sequence\)"):
            world.events(after=wrong)

"""The verbs become the messages of the contract, and a batch goes with the next step."""

import re
import subprocess
import sys

import grpc
import numpy as np
import pytest
from fake_server import FIRST_ID, FakeServer, answer_step, last_command, refuse

import genphys
from genphys import EntityOptions, ShapeOptions, _contract, _encode, _entity_verbs
from genphys._contract import wire
from genphys.commands import Commands


@pytest.fixture
def fake():
    with FakeServer(Step=answer_step) as server:
        yield server


@pytest.fixture
def world(fake):
    with genphys.connect(fake.address) as client:
        yield client.world("lab")


def test_shapes_and_bodies_are_described_by_keywords(world):
    with world.batch() as batch:
        batch.add_box(half_extents=(1, 2, 3), mass=4.0, friction=0.1, restitution=0.2, name="crate", position=(0, 0, 9))
        batch.add_sphere(radius=0.25, density=7.0, linear_velocity=(1, 0, 0), angular_velocity=(0, 0, 2))
        batch.add_plane(normal=(1, 0, 0), offset=-2.0)
        batch.add_entity(physics=False, name="sign", visual=genphys.Visual(uri="sign.glb"))
    box, sphere, plane, sign = (command.create_entity.entity for command in batch.commands)

    assert box.display_name == "crate"
    assert box.pose.position.z == 9
    assert not box.pose.HasField("orientation")
    assert box.rigid_body.inertia.mass == 4.0
    assert box.rigid_body.geometries[0].shape.box.half_extents.y == 2
    assert box.rigid_body.geometries[0].material.friction == 0.1
    assert not box.rigid_body.geometries[0].material.HasField("density")
    assert sphere.rigid_body.geometries[0].material.density == 7.0
    assert sphere.rigid_body.angular_velocity.z == 2
    assert (
        plane.rigid_body.motion_type
        == wire.Entity.DESCRIPTOR.file.pool.FindEnumTypeByName("genphys.v1.MotionType")
        .values_by_name["MOTION_TYPE_STATIC"]
        .number
    )
    assert not sign.HasField("rigid_body")
    assert sign.visual.uri == "sign.glb"


def test_a_wrong_argument_is_refused_before_it_is_sent(world, fake):
    with pytest.raises(ValueError, match="position has 2 numbers, not 3"):
        world.add_box(position=(0, 0))
    with pytest.raises(ValueError, match="mass or density"):
        world.add_box(mass=1.0, density=1.0)
    with pytest.raises(ValueError, match="motion is 'still', not one of: dynamic, kinematic, static"):
        world.add_box(motion="still")
    with pytest.raises(TypeError, match="'frction': did you mean 'friction'"):
        world.add_box(frction=1.0)
    with pytest.raises(TypeError, match="Entity or its id"):
        world.apply_force("ball", (1, 0, 0))
    with pytest.raises(ValueError, match=r"forces has shape \(3,\)"):
        world.apply_forces([1], (1, 2, 3))
    with pytest.raises(TypeError, match=r"shape is 'ball', not one of: genphys.Sphere\(...\), genphys.Box"):
        world.add_entity(geometries=[genphys.Geometry(shape="ball")])
    with pytest.raises(ValueError, match="not symmetric"):
        world.add_entity(mass=1.0, inertia_tensor=[[1, 2, 0], [0, 1, 0], [0, 0, 1]])

    assert fake.received("Step") == []
    assert fake.received("CreateEntity") == []


def test_an_inertia_tensor_may_be_a_matrix_or_its_six_numbers():
    matrix = np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 5.0], [3.0, 5.0, 6.0]])

    assert list(_encode.inertia(1.0, None, matrix).tensor) == [1, 2, 3, 4, 5, 6]
    assert list(_encode.inertia(1.0, None, [1, 2, 3, 4, 5, 6]).tensor) == [1, 2, 3, 4, 5, 6]


def test_each_verb_outside_a_batch_is_done_at_once(world, fake):
    world.apply_force(5, (1, 2, 3), point=(0, 0, 1), coordinates="entity", steps=9, replace=True)
    force = last_command(fake).apply_force
    assert (force.entity_id, force.force.y, force.point.z, force.steps, force.replace) == (5, 2, 1, 9, True)
    assert not force.HasField("torque")
    world.apply_impulse(5, angular=(0, 0, 4))
    assert last_command(fake).apply_impulse.angular.z == 4
    world.set_velocity(5, linear=(1, 0, 0))
    assert not last_command(fake).set_velocity.HasField("angular")
    world.set_pose(5, position=(1, 2, 3))
    assert not last_command(fake).set_pose.pose.HasField("orientation")
    world.set_pose(5, orientation=(0, 1, 0, 0), over_steps=7)
    assert not last_command(fake).set_pose.pose.HasField("position")
    assert last_command(fake).set_pose.over_steps == 7
    world.set_gravity((0, 0, -1.62))
    assert last_command(fake).set_gravity.gravity.z == -1.62
    world.set_engine("bullet")
    assert last_command(fake).set_engine.engine == "engines/bullet"
    world.set_stepper(step_size=0.01, solver="direct", substeps=2)
    assert last_command(fake).set_stepper.stepper.substeps == 2
    world.remove(5)
    assert last_command(fake).delete_entity.entity_id == 5

    assert all(request.HasField("steps") and request.steps == 0 for request in fake.received("Step"))


def test_columns_of_forces_come_from_arrays_and_from_entities(world, fake):
    forces = np.arange(6.0).reshape(2, 3)
    world.apply_forces(np.array([8, 9], np.uint64), forces)
    columns = last_command(fake).apply_forces
    assert np.frombuffer(columns.entity_ids, "<u8").tolist() == [8, 9]
    assert np.array_equal(np.frombuffer(columns.forces, "<f8").reshape(-1, 3), forces)
    assert columns.torques == b""

    world.apply_forces([genphys.Entity(8), 9], torques=forces.astype("f4")[::-1])
    columns = last_command(fake).apply_forces
    assert np.frombuffer(columns.entity_ids, "<u8").tolist() == [8, 9]
    assert np.frombuffer(columns.torques, "<f8").tolist() == [3, 4, 5, 0, 1, 2]


def test_a_batch_goes_with_the_next_step_in_order(world, fake):
    with world.batch() as batch:
        batch.set_gravity((0, 0, 0))
        ball = batch.add_sphere(name="ball")
    with world.batch() as batch:
        crate = batch.add_box(name="crate")
    with pytest.raises(ValueError, match="not created before the next step"):
        ball.id  # noqa: B018
    assert fake.received("Step") == []

    result = world.step(3)
    world.step()

    first, second = fake.received("Step")
    assert [command.WhichOneof("kind") for command in first.commands] == [
        "set_gravity",
        "create_entity",
        "create_entity",
    ]
    assert (first.steps, second.steps, len(second.commands)) == (3, 1, 0)
    assert result.created == (ball, crate)
    assert (ball.id, crate.id) == (FIRST_ID + 1, FIRST_ID + 2)


def test_a_batch_whose_block_raises_is_dropped(world, fake):
    with pytest.raises(ZeroDivisionError), world.batch() as batch:
        batch.set_gravity((0, 0, 0))
        1 / 0  # noqa: B018

    world.step()

    assert len(fake.received("Step")[0].commands) == 0


def test_a_refused_batch_is_not_sent_again(world, fake):
    field = "commands[0].set_gravity.gravity.x"
    fake.answers["Step"] = lambda request, context: refuse(
        context, grpc.StatusCode.INVALID_ARGUMENT, "OUT_OF_RANGE", "too much", field
    )
    with world.batch() as batch:
        batch.set_gravity((1e9, 0, 0))
    with pytest.raises(genphys.OutOfRangeError) as caught:
        world.step()
    assert caught.value.field == field

    fake.answers["Step"] = answer_step
    world.step()

    assert len(fake.received("Step")[1].commands) == 0


def test_a_step_asks_for_what_its_arguments_say(world, fake):
    world.step(5, frame=False, events=False, stats=True, step_size=0.5, expected_step=0)
    request = fake.received("Step")[-1]
    assert not request.HasField("frame")
    assert not request.HasField("events")
    assert (request.steps, request.stats, request.step_size_seconds) == (5, True, 0.5)
    assert request.HasField("expected_step")

    wanted = genphys.FrameRequest(velocities=False, entities=[3, genphys.Entity(4)], dtype="float32")
    world.step(frame=wanted, events=genphys.EventFilter(kinds=genphys.EventKinds(sleeping=False), entities=[3]))
    request = fake.received("Step")[-1]
    assert list(request.frame.entity_ids) == [3, 4]
    assert (request.frame.poses, request.frame.velocities) == (True, False)
    assert request.events.kinds.contacts and not request.events.kinds.sleeping
    assert not request.HasField("expected_step")


def test_a_world_leaves_to_the_server_what_is_not_said(fake):
    fake.answers["CreateWorld"] = lambda request, context: wire.CreateWorldResponse(world={"name": "worlds/w1"})
    with FakeServer(CreateWorld=fake.answers["CreateWorld"]) as server, genphys.connect(server.address) as client:
        assert client.create_world().name == "w1"
        client.create_world(name="lab", engine="ode", ground_plane=False, friction=0.3, required_features=["shape_box"])
        with pytest.raises(ValueError, match="mixing is 'max', not one of: average, geometric_mean, maximum"):
            client.create_world(friction_mixing="max")
        client.create_world(friction_mixing="maximum", restitution_mixing="multiply")
        mixing = server.received("CreateWorld").pop().world.defaults.material
        assert (mixing.friction_mixing, mixing.restitution_mixing) == (
            _contract.MIXING.number("maximum"),
            _contract.MIXING.number("multiply"),
        )
        plain, full = (request.world for request in server.received("CreateWorld")[:2])

    assert [field.name for field, _ in plain.ListFields()] in (["stepper", "defaults"], [])
    assert plain.stepper.ByteSize() == plain.defaults.ByteSize() == 0
    assert (full.name, full.engine, full.ground_plane) == ("worlds/lab", "engines/ode", False)
    assert full.HasField("ground_plane")
    assert full.defaults.material.friction == 0.3
    assert len(full.required_features) == 1


SHAPES = [name for name in dir(Commands) if name.startswith("add_") and name not in ("add_entity", "add_field")]


def test_it_can_be_had_without_docstrings():
    subprocess.run([sys.executable, "-OO", "-c", "import genphys"], check=True)


@pytest.mark.parametrize("verb", SHAPES)
def test_help_tells_the_keywords_of_what_adds_a_shape(world, verb):
    told = re.findall(r"^    (\w+): ", getattr(Commands, verb).__doc__.partition("Keywords:")[2], re.MULTILINE)

    assert sorted(told) == sorted(ShapeOptions.__annotations__) == sorted(_entity_verbs._SHAPE_KEYWORDS)


def test_help_tells_the_keywords_of_what_adds_and_changes_an_entity():
    for verb in (Commands.add_entity, Commands.update_entity):
        keywords = EntityOptions.__annotations__
        told = re.findall(r"^    (\w+): ", verb.__doc__.partition("Keywords:")[2], re.MULTILINE)
        assert sorted(told) == sorted(keywords)
        assert keywords.keys() | {"geometries", "physics"} == _encode.ENTITY_KEYWORDS

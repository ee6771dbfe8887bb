"""What the real server refuses is an exception with a reason and the path of the field."""

import math

import grpc
import pytest

import genphys
from genphys._contract import enum_names


def test_a_number_that_is_none_is_refused_with_its_path(world):
    with pytest.raises(genphys.NotFiniteError) as caught:
        world.add_sphere(position=(0, math.nan, 1))
    assert caught.value.field == "entity.pose.position.y"
    assert caught.value.code is grpc.StatusCode.INVALID_ARGUMENT
    assert caught.value.reason == "NOT_FINITE"

    ball = world.add_sphere(position=(0, 0, 1))
    with world.batch() as batch:
        batch.set_gravity((0, 0, 0))
        batch.apply_forces([ball, ball], [(0, 0, 0), (0, math.inf, 0)])
    with pytest.raises(genphys.NotFiniteError) as caught:
        world.step()
    assert caught.value.field == "commands[1].apply_forces.forces[1].y"


def test_values_beyond_their_limits_are_refused_and_their_neighbours_taken(world):
    with pytest.raises(genphys.OutOfRangeError) as caught:
        world.add_sphere(radius=0.0)
    assert caught.value.field == "entity.rigid_body.geometries[0].shape.sphere.radius"
    world.add_sphere(radius=1e-5, position=(0, 0, 1))
    with pytest.raises(genphys.NotUnitLengthError):
        world.add_sphere(orientation=(0, 0, 0, 0))
    world.add_sphere(orientation=(0, 0, 0, 1), position=(3, 0, 1))
    with pytest.raises(genphys.InvalidValueError):
        world.add_box(name="impossible", mass=1.0, position=(6, 0, 1), collision_space="/")


def test_an_inertia_that_no_body_has_is_refused(world):
    with pytest.raises(genphys.InvalidValueError):
        world.add_entity(mass=1.0, inertia_tensor=(1, 0, 0, 1, 0, 3))
    world.add_entity(mass=1.0, inertia_tensor=(1, 0, 0, 1, 0, 2), position=(0, 0, 9))


def test_ids_of_what_is_gone_and_of_what_never_was_are_told_apart(world):
    ball = world.add_sphere(position=(0, 0, 1))
    world.remove(ball)

    with pytest.raises(genphys.StaleIdError):
        world.entity(ball)
    with pytest.raises(genphys.StaleIdError):
        world.apply_force(ball, (1, 0, 0))
    with pytest.raises(genphys.EntityNotFoundError):
        world.entity((1 << 32) + 4000)
    with pytest.raises(genphys.MissingFieldError):
        world.entity(0)


def test_a_name_is_given_once(server):
    with server.create_world(name="only"), pytest.raises(genphys.AlreadyExistsError):
        server.create_world(name="only")
    server.create_world(name="only").delete()
    with pytest.raises(genphys.InvalidValueError):
        server.create_world(name="no/slash")


def test_what_an_engine_lacks_is_refused_by_name(server):
    features = set(enum_names("Feature", "FEATURE_").values())
    engine, missing = next(
        (each.name, features - each.features) for each in server.engines() if features - each.features
    )

    with pytest.raises(genphys.UnsupportedFeatureError) as caught:
        server.create_world(engine=engine, required_features=sorted(missing)[:1])

    assert caught.value.code is grpc.StatusCode.UNIMPLEMENTED
    server.create_world(engine=engine, required_features=sorted(features - missing)).delete()


def test_a_step_may_insist_on_where_the_world_is(world):
    world.step(3, expected_step=0)

    with pytest.raises(genphys.StepMismatchError):
        world.step(expected_step=0)

    assert world.step(expected_step=3).step == 4


def test_a_deleted_world_is_gone_for_all(server):
    world = server.create_world()
    world.delete()

    with pytest.raises(genphys.WorldNotFoundError):
        world.step()
    with pytest.raises(genphys.WorldNotFoundError):
        world.delete()

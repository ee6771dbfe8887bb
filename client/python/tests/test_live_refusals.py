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
    assert caught.value.argument == "position[1]"
    assert caught.value.code is grpc.StatusCode.INVALID_ARGUMENT
    assert caught.value.reason == "NOT_FINITE"

    ball = world.add_sphere(position=(0, 0, 1))
    with world.batch() as batch:
        batch.set_gravity((0, 0, 0))
        batch.apply_forces([ball, ball], [(0, 0, 0), (0, math.inf, 0)])
    with pytest.raises(genphys.NotFiniteError) as caught:
        world.step()
    assert caught.value.field == "commands[1].apply_forces.forces[1].y"
    assert str(caught.value) == "must be finite [NOT_FINITE at commands[1].apply_forces.forces[1][1]]"


def test_values_beyond_their_limits_are_refused_and_their_neighbours_taken(world):
    with pytest.raises(genphys.OutOfRangeError) as caught:
        world.add_sphere(radius=0.0)
    assert caught.value.field == "entity.rigid_body.geometries[0].shape.sphere.radius"
    assert caught.value.argument == "radius"
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


def test_an_engine_that_is_not_there_is_refused_with_those_that_are(server):
    names = [each.name for each in server.engines()]
    with server.create_world() as world:
        with pytest.raises(genphys.InvalidValueError) as caught:
            world.set_engine("physx")
        assert all(name in caught.value.message for name in names)
        with pytest.raises(genphys.InvalidValueError, match='there is no engine "Bullet"; there are: .*bullet.*, or none'):
            world.set_engine("Bullet")
    with pytest.raises(genphys.InvalidValueError, match='there is no engine "Bullet"; there are: .*bullet.*, or none'):
        server.create_world(engine="Bullet")


def test_a_world_without_an_engine_takes_none_that_lacks_what_it_requires(server):
    features = set(enum_names("Feature", "FEATURE_").values())
    engine, missing = next(
        (each.name, features - each.features) for each in server.engines() if features - each.features
    )
    with server.create_world(engine="none", required_features=sorted(missing)[:1]) as world:
        with pytest.raises(genphys.UnsupportedFeatureError):
            world.set_engine(engine)


def test_what_a_refused_batch_was_to_make_says_that_it_was_not_made(world):
    with world.batch() as batch:
        ball = batch.add_sphere()
        joint = batch.join(None, ball, genphys.joints.Ball())
        field = batch.add_field(genphys.fields.Drag(linear=0.5))
        batch.remove(1000)
    with pytest.raises(genphys.EntityNotFoundError):
        world.step()

    for handle in (ball, joint, field):
        with pytest.raises(ValueError, match="was not created: the step that took its batch along failed"):
            handle.id


def test_bytes_that_are_no_text_are_refused_with_the_reason(server):
    with server.create_world(name="texts"), grpc.insecure_channel(server.address) as channel:
        call = channel.unary_unary("/genphys.v1.SimulationService/CreateEntity")
        with pytest.raises(grpc.RpcError) as caught:
            call(b"\n\x0cworlds/texts\x12\x04\x12\x02\xff\xfe")

    assert "a string in them is no UTF-8" in caught.value.details()


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


def test_a_world_takes_no_handle_of_another_one(server, space):
    drag = genphys.fields.Drag(linear=0.5)
    with server.create_world() as other:
        ball = other.add_sphere(position=(0, 0, 5))
        joint = other.join(None, ball, genphys.joints.Ball())
        field = other.add_field(drag)
        mine = space.add_sphere()
        with other.batch() as batch:
            batched = batch.add_sphere()
        told = next(each.entity for each in other.step().events if isinstance(each, genphys.EntityCreated))
        wrong = [ball, told, batched, other.entity(ball), other.entities()[0]]

        refused = [
            lambda each: space.apply_impulse(each, (0, 0, 1)),
            lambda each: space.apply_force(each, (0, 0, 1)),
            lambda each: space.apply_forces([mine, each], [(0, 0, 1)] * 2),
            lambda each: space.join(mine, each, genphys.joints.Ball()),
            lambda each: space.add_field(genphys.fields.Spring(a=mine, b=each)),
            lambda each: space.add_field(drag, entities=[each]),
            lambda each: space.add_sphere(ignored_entities=[each]),
            lambda each: space.update_entity(each, name="other"),
            lambda each: space.set_pose(each, position=(0, 0, 0)),
            lambda each: space.set_velocity(each, linear=(0, 0, 0)),
            lambda each: space.remove(each),
            lambda each: space.entity(each),
            lambda each: space.contacts_of(each),
            lambda each: space.distances([mine], [each]),
            lambda each: space.step(frame=genphys.FrameRequest(entities=[each])),
            lambda each: space.events(genphys.EventFilter(entities=[each])),
        ]
        for handle in wrong:
            for call in refused:
                with pytest.raises(ValueError, match=f"is of the world worlds/{other.name}, not of worlds/{space.name}"):
                    call(handle)
        for call in (
            lambda: space.remove_joint(joint),
            lambda: space.remove_joint(other.joints()[0]),
            lambda: space.set_motors([joint], [1.0]),
            lambda: space.remove_field(field),
            lambda: space.update_field(other.fields()[0], drag),
        ):
            with pytest.raises(ValueError, match="is of the world"):
                call()
        # Another hand on the same world has its handles, and a number is what somebody says it is.
        server.world(other.name).apply_impulse(ball, (0, 0, 1))
        space.apply_impulse(mine.id, (0, 0, 1))

"""Many worlds in one call, steps that are not waited for, and frames of which only changes are sent."""

import numpy as np
import pytest

import genphys
from genphys.drive import IN_FLIGHT_MAX

WORLDS = 5
DEADLINE_SECONDS = 0.5
TRIES = 20
AWAKE = genphys.AutoDisable(enabled=False)


def make_world(server, engine, height):
    world = server.create_world(engine=engine)
    world.add_sphere(radius=0.5, mass=1.0, position=(0, 0, height))
    return world


@pytest.fixture(params=["bullet", "ode"])
def engine(request):
    """Each engine in turn."""
    return request.param


def test_many_worlds_are_stepped_in_one_call_as_if_each_were_alone(server, engine):
    worlds = [make_world(server, engine, 0.6 + 0.1 * index) for index in range(WORLDS)]
    twins = [make_world(server, engine, 0.6 + 0.1 * index) for index in range(WORLDS)]
    with worlds[1].batch() as batch:
        crate = batch.add_box(half_extents=(0.5, 0.5, 0.5), mass=1.0, position=(5, 0, 2))
    with twins[1].batch() as batch:
        batch.add_box(half_extents=(0.5, 0.5, 0.5), mass=1.0, position=(5, 0, 2))

    results = server.step_worlds(worlds, 60)

    assert [result.step for result in results] == [60] * WORLDS
    assert crate.id in results[1].ids
    for result, twin in zip(results, twins):
        alone = twin.step(60)
        assert result.positions.tobytes() == alone.positions.tobytes()
        assert [type(event) for event in result.events] == [type(event) for event in alone.events]
    for world in [*worlds, *twins]:
        world.delete()


def test_one_world_that_refuses_does_not_harm_the_others(server, engine):
    good, gone, wrong = (make_world(server, engine, 1.0) for _ in range(3))
    gone.delete()
    with wrong.batch() as batch:
        batch.remove(12345)

    results = server.step_worlds([good, gone, wrong])

    assert results[0].step == 1
    assert isinstance(results[1], genphys.WorldNotFoundError)
    assert isinstance(results[2], genphys.EntityNotFoundError)
    assert results[2].field == "commands[0].delete_entity.entity_id"
    assert server.step_worlds([]) == []


def test_a_world_of_another_server_is_not_taken_for_one_of_the_same_name(server):
    with genphys.launch() as other, server.create_world(name="twin") as world:
        twin = other.create_world(name="twin")
        with pytest.raises(ValueError, match=r"worlds\[1\]"):
            server.step_worlds([world, twin])

        assert world.info().stamp.step == 0
        # Another connection to the same server is as good.
        with genphys.connect(server.address) as again:
            assert again.step_worlds([world])[0].step == 1


def test_what_a_batch_created_has_ids_when_its_steps_end_at_the_deadline(server, engine):
    def step_alone(world):
        with pytest.raises(genphys.DeadlineExceededError) as caught:
            world.step(100_000, timeout=DEADLINE_SECONDS)
        return caught.value

    def step_with_others(world):
        return server.step_worlds([world], 100_000, timeout=DEADLINE_SECONDS)[0]

    for step in (step_alone, step_with_others):
        # A machine that is busy elsewhere may bring the reply too late now and then.
        for _ in range(TRIES):
            with server.create_world(engine=engine) as world:
                with world.batch() as batch:
                    batch.set_gravity((0, 0, -5))
                    boxes = [batch.add_box(position=(3 * i, 0, 0.5), auto_disable=AWAKE) for i in range(20)]
                error = step(world)
                if "step" in error.metadata:
                    break
        assert isinstance(error, genphys.DeadlineExceededError)
        assert int(error.metadata["steps_done"]) > 0
        assert [box.id for box in boxes] == list(range(2, 22))


def test_steps_are_driven_without_waiting_for_each(world):
    ball = world.add_sphere(radius=0.5, mass=1.0, position=(0, 0, 5))

    with world.drive() as drive:
        for _ in range(IN_FLIGHT_MAX):
            drive.send()
        with pytest.raises(ValueError, match="receive one first"):
            drive.send()
        heights = []
        for step in range(1, 101):
            result = drive.receive()
            assert result.step == step
            heights.append(result.positions[result.row(ball), 2])
            if step + IN_FLIGHT_MAX <= 100:
                drive.send()
        assert drive.in_flight == 0
        with pytest.raises(ValueError, match="send first"):
            drive.receive()

    assert heights == sorted(heights, reverse=True)


def test_a_drive_that_was_closed_takes_no_commands_along(world):
    drive = world.drive()
    drive.close()
    with world.batch() as batch:
        ball = batch.add_sphere(position=(0, 0, 5))

    with pytest.raises(ValueError, match="closed"):
        drive.send()

    frame = world.step()
    assert ball.id in frame.ids


def test_a_driven_step_that_is_refused_is_told_in_its_place(world):
    with world.drive() as drive:
        drive.send()
        drive.send(expected_step=5)
        with world.batch() as batch:
            batch.apply_force(12345, (0, 0, 1))
        drive.send()
        drive.send()

        assert drive.receive().step == 1
        with pytest.raises(genphys.StepMismatchError):
            drive.receive()
        with pytest.raises(genphys.EntityNotFoundError) as caught:
            drive.receive()
        assert caught.value.field == "commands[0].apply_force.entity_id"
        assert drive.receive().step == 2


def test_deltas_come_out_as_whole_frames(world):
    boxes = [
        world.add_box(half_extents=(0.5, 0.5, 0.5), mass=1.0, position=(2.0 * index, 0, 0.5)) for index in range(20)
    ]
    world.step(300)
    wanted = genphys.FrameRequest(deltas=True, net_forces=True)
    with world.frames(wanted) as stream, world.drive() as drive:
        next(stream)
        for step in range(60):
            if step % 7 == 0:
                world.set_velocity(boxes[step % 20], linear=(0, 0, 3))
                next(stream)
            if step == 30:
                world.remove(boxes.pop())
                next(stream)
            stepped = world.step(frame=wanted)
            whole = world.step(0, frame=genphys.FrameRequest(net_forces=True))
            pushed = next(stream)
            drive.send(0, frame=wanted)
            driven = drive.receive()
            for merged in (stepped, pushed, driven):
                assert merged.ids.tolist() == whole.ids.tolist()
                for column in ("positions", "orientations", "linear_velocities", "angular_velocities", "net_forces"):
                    assert getattr(merged, column).tobytes() == getattr(whole, column).tobytes()
                assert np.array_equal(merged.asleep, whole.asleep)


def test_statistics_of_a_step_can_be_read_by_people(world):
    world.add_sphere(radius=0.5, mass=1.0, position=(0, 0, 0.5))

    text = str(world.step(stats=True).stats)

    assert text.startswith("entities: 0 asleep, ")
    assert text.splitlines()[-1].split()[0] == "step"
    assert text.endswith("100.0 %")

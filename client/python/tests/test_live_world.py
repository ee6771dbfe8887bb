"""A world on the real server does what the verbs say."""

import copy
import pathlib
import pickle
import time

import numpy as np
import pytest
from conftest import ENGINES, GRAVITY, STEP_SIZE

import genphys

# The same state through another representation of the same double numbers.
ROUNDING = 1e-12
# Semi-implicit Euler, the coarsest integrator that an engine has, is off by half a step of the final speed.
FALL_STEPS = 120
FALL_TIME = FALL_STEPS * STEP_SIZE
PATIENCE_SECONDS = 30.0
FALL_TOLERANCE = GRAVITY * FALL_TIME * STEP_SIZE / 2 + ROUNDING


def test_the_server_tells_its_engines_and_what_they_can_do(server):
    engines = {engine.name: engine for engine in server.engines()}

    assert set(ENGINES) <= set(engines)
    assert {"shape_sphere", "shape_box", "contacts", "ray_casts"} <= engines["ode"].features
    assert engines["ode"].version


def test_a_world_is_listed_joined_and_deleted_at_the_end_of_its_block(server):
    with server.create_world(name="short-lived", engine="ode", gravity=(0, 0, -1)) as world:
        assert "short-lived" in [each.name for each in server.list_worlds()]
        with server.world("short-lived") as joined:
            info = joined.info()
        assert world.info() == info
    assert (info.engine, info.state, info.gravity, info.stamp.step) == ("ode", "paused", (0, 0, -1), 0)
    assert info.step_size == pytest.approx(1 / 60, rel=ROUNDING)

    with pytest.raises(genphys.WorldNotFoundError):
        server.world("short-lived")


def test_a_ball_falls_as_galilei_says(world):
    ball = world.add_sphere(radius=0.5, mass=1.0, position=(1, 2, 10))

    frame = world.step(FALL_STEPS)

    row = frame.row(ball)
    assert frame.step == FALL_STEPS
    assert frame.time == pytest.approx(FALL_TIME, rel=ROUNDING)
    assert frame.positions[row] == pytest.approx([1, 2, 10 - GRAVITY * FALL_TIME**2 / 2], abs=FALL_TOLERANCE)
    assert frame.linear_velocities[row] == pytest.approx([0, 0, -GRAVITY * FALL_TIME], rel=1e-9)
    assert frame.orientations[row].tolist() == [1, 0, 0, 0]
    assert not frame.asleep[row]


def test_an_entity_is_described_as_it_was_made_and_as_it_is(world):
    crate = world.add_box(
        name="crate",
        half_extents=(0.1, 0.2, 0.3),
        mass=2.0,
        friction=0.25,
        rolling_friction=0.01,
        position=(0, 0, 5),
        orientation=(0, 1, 0, 0),
    )
    world.set_velocity(crate, angular=(0, 0, 3))

    info = world.entity(crate)

    assert (info.entity, info.name, info.motion, info.mass) == (crate, "crate", "dynamic", 2.0)
    assert info.position == (0, 0, 5)
    assert info.orientation == (0, 1, 0, 0)
    assert info.angular_velocity == (0, 0, 3)
    assert info.geometries[0].shape == genphys.Box((0.1, 0.2, 0.3))
    assert info.geometries[0].friction == 0.25
    assert info.geometries[0].rolling_friction == 0.01
    assert info.geometries[0].spinning_friction == 0.0
    assert [each.name for each in world.entities()] == ["ground", "crate"]


def test_a_sign_without_physics_stays_where_it_is_put(world):
    sign = world.add_entity(
        name="sign", physics=False, position=(0, 0, 3), visual=genphys.Visual(uri="sign.glb", data=b"\0\1")
    )

    world.step(10)

    info = world.entity(sign)
    assert not info.physics
    assert info.position == (0, 0, 3)
    assert info.visual == genphys.Visual(uri="sign.glb", data=b"\0\1")


def test_a_batch_and_its_step_are_one_round_trip(world):
    with world.batch() as batch:
        batch.set_gravity((0, 0, 0))
        low = batch.add_sphere(name="low", mass=1.0, position=(0, 0, 5), linear_velocity=(0, 0, 1))
        high = batch.add_sphere(name="high", mass=1.0, position=(0, 0, 9))

    frame = world.step(240)

    assert frame.created == (low, high)
    assert frame.positions[frame.row(low)] == pytest.approx([0, 0, 6], abs=1e-9)
    assert frame.positions[frame.row(high)].tolist() == [0, 0, 9]
    created = [event for event in frame.events if isinstance(event, genphys.EntityCreated)]
    assert [str(event.entity) for event in created] == ["low", "high"]


def test_columns_of_forces_act_for_one_step_on_whom_they_name(space):
    balls = [space.add_sphere(mass=float(mass), position=(3 * mass, 0, 0)) for mass in (1, 2, 4)]
    forces = np.array([[240.0, 0, 0], [0, 240.0, 0]])

    with space.batch() as batch:
        batch.apply_forces(balls[:2], forces)
    frame = space.step(5)

    # F t / m with F = 240 N over 1/240 s.
    rows = [frame.row(ball) for ball in balls]
    expected = [[1, 0, 0], [0, 0.5, 0], [0, 0, 0]]
    assert frame.linear_velocities[rows] == pytest.approx(np.array(expected), abs=1e-9)


def test_single_verbs_act(space):
    ball = space.add_sphere(mass=2.0)

    space.apply_force(ball, (480, 0, 0), steps=3)
    space.apply_impulse(ball, (0, 4, 0))
    frame = space.step(10)
    assert frame.linear_velocities[frame.row(ball)] == pytest.approx([3, 2, 0], abs=1e-9)

    space.set_pose(ball, position=(7, 0, 0))
    space.set_velocity(ball, linear=(0, 0, 0))
    space.set_gravity((0, 0, -GRAVITY))
    space.set_stepper(step_size=0.01)
    frame = space.step()
    assert frame.linear_velocities[frame.row(ball)] == pytest.approx([0, 0, -GRAVITY * 0.01], abs=1e-9)
    assert frame.positions[frame.row(ball)][0] == pytest.approx(7, abs=1e-9)

    space.remove(ball)
    assert len(space.step()) == 0


def test_a_frame_has_only_what_was_asked_for(world):
    ball = world.add_sphere(position=(0, 0, 5))
    world.add_sphere(position=(3, 0, 5))

    some = world.step(frame=genphys.FrameRequest(velocities=False, entities=[ball], dtype="float32"))
    none = world.step(frame=False, events=False, stats=True)

    assert some.ids.tolist() == [ball.id]
    assert some.positions.dtype == np.float32
    with pytest.raises(AttributeError):
        some.linear_velocities  # noqa: B018
    assert (len(none), none.step, none.events) == (0, 2, ())
    for column in ("positions", "linear_velocities", "net_forces", "joint_positions", "asleep"):
        with pytest.raises(AttributeError, match="asked for"):
            getattr(none, column)
    with pytest.raises(AttributeError, match="joint_rates were not asked for"):
        some.joint_rates  # noqa: B018
    assert none.stats.entities_in_flight + none.stats.entities_in_engine == 2


def test_a_call_without_steps_has_no_statistics_and_not_all_zeros(world):
    world.add_sphere(position=(0, 0, 5))
    assert world.step(3, stats=True).stats is not None
    assert world.step(0, stats=True).stats is None
    assert world.step(1).stats is None


def test_a_frame_of_an_empty_world_tells_what_was_asked_for_from_what_was_not(space):
    with space.frames(genphys.FrameRequest(velocities=False)) as stream:
        frames = [next(stream), space.step(frame=genphys.FrameRequest(velocities=False))]

    for frame in frames:
        assert frame.positions.shape == (0, 3)
        with pytest.raises(AttributeError, match="angular_velocities were not asked for"):
            frame.angular_velocities  # noqa: B018


def test_a_result_says_which_events_it_has_no_room_for(space):
    room = 16  # entities with a visual of 1 MiB
    with space.batch() as batch:
        for _ in range(room + 1):
            batch.add_entity(physics=False, visual=genphys.Visual(data=bytes(1 << 20)))

    with pytest.warns(genphys.EventsLeftOutWarning, match=f"{room + 1} to {room + 1}") as told:
        frame = space.step(0)

    assert told[0].filename == __file__
    assert len(frame.events) == room
    assert frame.events_left_out == genphys.Gap(room + 1, room + 1)
    with space.events(after=(frame.epoch, frame.events[-1].sequence)) as rest:
        assert next(rest).entity == frame.created[-1]
    assert space.step().events_left_out is None


def test_rays_hit_the_nearest_thing_in_their_way(world):
    crate = world.add_box(half_extents=(0.5, 0.5, 0.5), position=(0, 0, 0.5), motion="static")

    hits = world.cast_rays([(0, 0, 5), (0, 0, 5), (9, 0, 5)], [(0, 0, -8), (0, 0, 8), (0, 0, -10)])

    assert hits.hit.tolist() == [True, False, True]
    assert hits.entity_ids[0] == crate.id
    assert hits.points[0] == pytest.approx([0, 0, 1], abs=1e-6)
    assert hits.points[2] == pytest.approx([9, 0, 0], abs=1e-6)
    assert hits.normals[0] == pytest.approx([0, 0, 1], abs=1e-6)
    assert hits.fractions[0] == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("other", [*ENGINES, "none"])
def test_a_flying_ball_does_not_notice_a_change_of_engine(world, other):
    ball = world.add_sphere(mass=1.0, position=(0, 0, 50), linear_velocity=(1, 2, 3), angular_velocity=(0, 1, 0))
    before = world.step(10)
    engine = world.info().engine

    world.set_engine(other)
    after = world.step(0)
    assert world.info().engine == other
    world.set_engine(engine)

    for name in ("positions", "orientations", "linear_velocities", "angular_velocities"):
        assert getattr(after, name)[after.row(ball)] == pytest.approx(
            getattr(before, name)[before.row(ball)], abs=ROUNDING
        )


def test_a_world_that_plays_moves_by_itself_until_it_is_paused(world):
    world.add_sphere(position=(0, 0, 5))

    world.play(0)
    with pytest.raises(genphys.WorldNotPausedError):
        world.step()
    assert world.info().state == "playing"
    with world.frames() as frames:
        while next(frames).step == 0:
            pass
    stopped = world.pause()

    assert stopped.step > 0
    assert world.info().state == "paused"
    assert world.step().step == stopped.step + 1


def test_an_episode_comes_out_the_same_after_a_reset(world):
    ball = world.add_sphere(position=(0, 0, 30), mass=2.5)
    ends = []
    for episode in range(3):
        if episode > 0:
            world.reset()
        world.apply_force(ball, (1, 0, 0), steps=5)
        with world.batch() as batch:
            batch.apply_forces([ball], [(0, 7.5, 0)])
            other = batch.add_sphere(position=(20, 0, 5))
        result = world.step(10)
        ends.append((other.id, result.ids.tolist(), result.positions.tolist(), result.linear_velocities.tolist()))
    assert ends[1] == ends[0] and ends[2] == ends[0]


def test_a_reset_drops_what_was_collected_for_the_next_step(world):
    ball = world.add_sphere(position=(0, 0, 30), mass=1)
    world.step()
    with world.batch() as batch:
        batch.apply_force(ball, (100, 0, 0))
    world.reset()
    assert world.step(frame=genphys.FrameRequest(velocities=True)).linear_velocities[:, 0].max() == 0


def test_a_reset_takes_the_world_back_in_a_new_epoch(world):
    before = world.step(5)

    stamp = world.reset()

    assert (stamp.step, stamp.time) == (0, 0.0)
    assert stamp.epoch != before.epoch


def test_state_hashes_are_there_when_the_world_records_them(server, world):
    assert world.step().state_hash is None
    with server.create_world(record_state_hash=True) as recorded:
        hashes = {recorded.step().state_hash for _ in range(2)}
    assert None not in hashes


@pytest.mark.parametrize("engine", ENGINES)
def test_fields_push_until_they_are_removed(server, engine):
    with server.create_world(engine=engine, gravity=(0, 0, 0), ground_plane=False) as world:
        pushed = world.add_sphere(mass=2.0, position=(0, 0, 0))
        left_alone = world.add_sphere(mass=2.0, position=(5, 0, 0))
        field = world.add_field(genphys.fields.Uniform(force=(0, 0, 4)), entities=[pushed])
        frame = world.step(60)
        assert frame.linear_velocities[frame.row(pushed)] == pytest.approx([0, 0, 2], rel=1e-9)
        assert frame.linear_velocities[frame.row(left_alone)].tolist() == [0, 0, 0]

        world.update_field(field, genphys.fields.Drag(linear=1e6))
        frame = world.step(1)
        assert frame.linear_velocities[frame.row(pushed)] == pytest.approx([0, 0, 0], abs=1e-9)

        world.remove_field(field)
        with pytest.raises(genphys.EntityNotFoundError):
            world.remove_field(field)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_field_of_a_batch_has_its_id_once_the_batch_was_taken_along(server, engine):
    with server.create_world(engine=engine, gravity=(0, 0, 0), ground_plane=False) as world:
        a, b = world.add_sphere(position=(0, 0, 0)), world.add_sphere(position=(3, 0, 0))
        with world.batch() as batch:
            spring = batch.add_field(genphys.fields.Spring(a=a, b=b, rest_length=1.0, stiffness=50.0))
            with pytest.raises(ValueError, match="taken along its batch"):
                batch.remove_field(spring)
        frame = world.step(10)
        assert frame.linear_velocities[frame.row(a)][0] > 0 > frame.linear_velocities[frame.row(b)][0]
        assert spring.id == 1


def resident_bytes(pid):
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return 1024 * int(line.split()[1])
    raise AssertionError("no such process")


@pytest.mark.parametrize("engine", ENGINES)
def test_memory_of_deleted_worlds_goes_back_to_the_system(binary, engine):
    with genphys.launch(binary=binary) as own:
        pid = own._process.pid
        before = resident_bytes(pid)
        worlds = [own.create_world(engine=engine) for _ in range(50)]
        for world in worlds:
            with world.batch() as batch:
                for i in range(300):
                    batch.add_box(half_extents=(0.5, 0.5, 0.5), mass=1.0, position=(2.0 * i, 0, 0.5))
            world.step(2)
        grown = resident_bytes(pid) - before

        for world in worlds:
            world.delete()

        end = time.monotonic() + PATIENCE_SECONDS
        while resident_bytes(pid) - before > grown / 2:
            assert time.monotonic() < end, f"{resident_bytes(pid) - before} of {grown} bytes are still held"
            time.sleep(0.1)
        assert grown > 10e6


def test_a_result_goes_to_other_processes_and_a_world_tells_how_to_get_there(server, world):
    with world.batch() as batch:
        ball = batch.add_sphere(name="ball", position=(0, 0, 0.4))
    result = world.step(3, stats=True)

    for copied in (copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))):
        other = copied(result)
        assert type(other) is genphys.StepResult
        assert np.array_equal(other.positions, result.positions)
        assert (other.events, other.stats, other.created, other.events_left_out) == (
            result.events,
            result.stats,
            (ball,),
            None,
        )
        assert other.events and other.created[0].name == "ball"
        with world.drive() as drive, world.events() as events, world.frames() as frames:
            for connected in (world, server, drive, events, frames):
                with pytest.raises(TypeError, match="pass on server.address and world.name"):
                    copied(connected)


def test_a_world_tells_which_events_it_records(server, world):
    assert world.info().recorded_events == genphys.EventKinds()
    kinds = genphys.EventKinds(persisting_contacts=True, changes=False)
    with server.create_world(recorded_events=kinds) as other:
        assert other.info().recorded_events == kinds


def test_no_rays_hit_nothing(world):
    assert world.cast_rays([], []).hit.shape == (0,)
    assert len(world.find_overlaps(genphys.Sphere(1), []).places) == 0

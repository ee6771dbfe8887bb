"""Events and frames of the real server reach those who watch."""

import gc
import json
import os
import pathlib
import queue
import subprocess
import sys
import threading
import time

import conftest
import grpc
import pytest
from conftest import ENGINES

import genphys

CHECKOUT = pathlib.Path(__file__).resolve().parents[3]
EXAMPLE = CHECKOUT / "examples" / "python" / "crate_and_ball.py"
# A program that starts Python, a server and a scene takes a second or two, under a sanitizer ten times as long.
PROGRAM_SECONDS = 120
# Less than the 3 s that a server gives to calls that are under way.
PROMPT_SECONDS = 2.0
# How long the end of a process may take to be seen.
END_SECONDS = 10.0
# Until what a busy viewer is sent has been read in its place.
STAND_IN_SECONDS = 0.5
BUSY_SECONDS = 0.1


def drop_ball(world):
    """A ball that touches the floor, and sleeps."""
    world.add_sphere(name="ball", radius=0.5, mass=1.0, position=(0, 0, 0.51))
    return world.step(240)


def test_a_watcher_gets_the_events_that_the_stepper_gets(world):
    stream = world.events()

    stepped = list(drop_ball(world).events)
    watched = [next(stream) for _ in range(len(stepped) + 1)]

    # The creation came before the step.
    assert isinstance(watched[0], genphys.EntityCreated)
    assert watched[1:] == stepped
    numbers = [event.sequence for event in watched]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    kinds = [type(event) for event in stepped]
    assert kinds.index(genphys.ContactBegan) < kinds.index(genphys.EntitySlept)
    touch = next(event for event in stepped if isinstance(event, genphys.ContactBegan))
    assert (str(touch.entity_a), str(touch.entity_b)) == ("ground", "ball")
    stream.close()


def test_a_watcher_goes_on_where_an_earlier_one_stopped(world):
    with world.events() as first:
        expected = drop_ball(world).events
        next(first)
        position = first.position

    with world.events(after=(position.epoch, expected[0].sequence - 1)) as second:
        assert [next(second) for _ in expected] == list(expected)


def test_a_filter_leaves_out_what_is_not_wanted(world):
    kinds = genphys.EventKinds(contacts=False, contact_points=False, sensors=False, joints=False, changes=False)
    with world.events(genphys.EventFilter(kinds=kinds)) as sleep:
        drop_ball(world)
        assert isinstance(next(sleep), genphys.EntitySlept)


def test_a_watcher_is_told_of_a_reset(world):
    with world.events() as stream:
        drop_ball(world)
        epoch = world.reset().epoch
        while not isinstance(event := next(stream), genphys.EpochBegan):
            pass
        assert event.epoch == epoch


def test_frames_are_pushed_to_those_who_do_not_step(world):
    ball = world.add_sphere(position=(0, 0, 5))
    with world.frames(every=2) as frames:
        first = next(frames)
        world.step()
        stepped = world.step()
        while (pushed := next(frames)).step < 2:
            pass

    assert first.step == 0
    assert pushed.step == 2
    assert pushed.positions[pushed.row(ball)].tolist() == stepped.positions[stepped.row(ball)].tolist()


@pytest.mark.parametrize("deltas", [False, True])
def test_a_viewer_that_was_busy_gets_the_newest_frame_and_how_many_it_missed(space, deltas):
    balls = [space.add_sphere(position=(3.0 * i, 0, 0), linear_velocity=(0, 0, i % 5 == 0)) for i in range(20)]
    with space.frames(genphys.FrameRequest(deltas=deltas)) as frames:
        seen = next(frames)
        # Far less than what fits into the windows of a connection.
        for steps in (1, 40, 1, 1, 40):
            for _ in range(steps):
                stepped = space.step()
            time.sleep(STAND_IN_SECONDS)
            before, seen = seen, next(frames)

            assert seen.step == stepped.step
            assert seen.skipped_frames == seen.step - before.step - 1
            assert seen.positions[seen.row(balls[5])].tolist() == stepped.positions[stepped.row(balls[5])].tolist()


def test_a_viewer_that_keeps_the_interpreter_busy_gets_a_recent_frame(space):
    space.add_sphere()
    with space.frames() as frames:
        next(frames)
        space.play(2)
        for _ in range(15):
            busy_until = time.monotonic() + BUSY_SECONDS
            while time.monotonic() < busy_until:
                pass
            shown = next(frames).step
            age = (space.info().stamp.step - shown) * conftest.STEP_SIZE / 2
        space.pause()

    # What nobody reads piles up for as long as the viewer is behind: 1.5 s here.
    assert age < 6 * BUSY_SECONDS


def test_a_viewer_that_nobody_listens_to_any_more_goes_with_its_thread(space):
    def viewers():
        return [thread for thread in threading.enumerate() if thread.name == "genphys frames"]

    frames = space.frames()
    before = len(viewers())
    del frames
    gc.collect()

    assert len(viewers()) == before - 1


def test_a_stream_that_waits_can_be_closed_by_another_thread(world):
    stream = world.events()
    timer = threading.Timer(0.2, stream.close)
    timer.start()

    assert list(stream) == []
    timer.join()


@pytest.mark.parametrize("left_open", ["events", "frames", "nothing"])
def test_a_server_ends_at_once_whatever_its_client_has_open(binary, left_open):
    server = genphys.launch(binary=binary)
    world = server.create_world()
    stream = None if left_open == "nothing" else getattr(world, left_open)()
    world.step()

    begin = time.monotonic()
    server.close()

    assert time.monotonic() - begin < PROMPT_SECONDS
    # What had arrived is still there; then the iteration ends.
    assert stream is None or len(list(stream)) <= 1


@pytest.mark.parametrize("watches", ["health", "reflection"])
def test_a_server_ends_at_once_whoever_asks_what_it_is(binary, watches):
    with genphys.launch(binary=binary) as server, grpc.insecure_channel(server.address) as channel:
        if watches == "health":
            call = channel.unary_stream("/grpc.health.v1.Health/Watch")(b"")
        else:
            name = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"
            requests = queue.SimpleQueue()
            requests.put(b"\x3a\x00")  # list_services
            call = channel.stream_stream(name)(iter(requests.get, None))
        next(call)

        begin = time.monotonic()
        server.close()

        assert time.monotonic() - begin < PROMPT_SECONDS
        if watches == "health":
            assert next(call) == b"\x08\x02"  # NOT_SERVING
        else:
            requests.put(None)


def test_streams_go_on_at_a_server_that_is_stopped_and_started_again(binary, tmp_path):
    address = f"unix:{tmp_path}/s"

    def start():
        command = [binary, "--listen", address, "--log-level", "off"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        process.stdout.readline()
        with genphys.connect(address) as client:
            client.create_world(name="lab").add_sphere()
        return process

    for _ in range(3):
        first = start()
        with genphys.connect(address) as client:
            world = client.world("lab")
            events, frames = world.events(), world.frames()
            next(frames)
            first.terminate()
            first.wait()
            second = start()
            world.step()
            while next(frames).step == 0:
                pass
            while not isinstance(next(events), genphys.EpochBegan):
                pass
            second.terminate()
            second.wait()


@pytest.mark.parametrize("engine", ENGINES)
def test_the_example_comes_out_as_documented(binary, engine):
    result = run(binary, str(EXAMPLE), "--engine", engine)

    assert result.returncode == 0, result.stdout + result.stderr
    assert "crate and ball touch" in result.stdout
    assert "NOT EXPECTED" not in result.stdout


def test_the_readme_begins_with_a_program_that_runs(binary):
    readme = (CHECKOUT / "client" / "python" / "README.md").read_text()
    program = readme.partition("```python\n")[2].partition("```")[0]

    result = run(binary, "-c", program)

    assert (result.returncode, result.stderr) == (0, "")
    assert "ContactBegan" in result.stdout


def test_the_command_shows_events_as_they_come(server):
    with server.create_world(name="shown") as world:
        command = [sys.executable, "-m", "genphys.watch", "--address", server.address, "--json", "shown"]
        watcher = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment(), bufsize=1
        )
        with watcher:
            assert watcher.stderr.readline().startswith("watching shown")
            drop_ball(world)
            created = json.loads(watcher.stdout.readline())
            touch = json.loads(watcher.stdout.readline())
            watcher.terminate()

    assert (created["kind"], created["entity"]["name"]) == ("EntityCreated", "ball")
    assert (touch["kind"], touch["entity_a"]["name"], touch["entity_b"]["name"]) == ("ContactBegan", "ground", "ball")


@pytest.mark.parametrize(
    "ending",
    [
        pytest.param("events = server.create_world().events()", id="exit with an open stream"),
        pytest.param("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", id="kill"),
    ],
)
def test_a_private_server_does_not_outlive_its_program(binary, ending):
    program = f"import genphys; server = genphys.launch(); print(server._process.pid, flush=True); {ending}"
    result = run(binary, "-c", program)

    assert result.stderr == ""
    pid = int(result.stdout)
    give_up_at = time.monotonic() + END_SECONDS
    while alive(pid) and time.monotonic() < give_up_at:
        time.sleep(0.05)
    assert not alive(pid)


def test_a_private_server_lives_as_long_as_anything_that_uses_it(binary):
    world = genphys.launch(binary=binary).create_world()
    gc.collect()
    assert world.step().step == 1
    pid = world._connection._keep_alive.pid

    begin = time.monotonic()
    del world
    gc.collect()

    assert not alive(pid)
    assert time.monotonic() - begin < PROMPT_SECONDS


def environment(**more):
    return {**os.environ, "PYTHONPATH": str(CHECKOUT / "client" / "python"), **more}


def run(binary, *arguments):
    return subprocess.run(
        [sys.executable, *arguments],
        capture_output=True,
        text=True,
        timeout=PROGRAM_SECONDS,
        check=False,
        env=environment(GENPHYS_SERVER=binary),
    )


def alive(pid):
    """Whether a process runs; one that ended and waits for its parent does not."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False

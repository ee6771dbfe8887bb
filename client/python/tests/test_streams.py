"""Streams come back after a lost connection, lose and repeat nothing in silence, and end when told to."""

import copy
import dataclasses
import pickle
import struct
import threading
import time

import grpc
import pytest
from fake_server import EPOCH, FakeServer, batch, refuse

import genphys
from genphys import events, streams
from genphys._contract import wire

SLEPT = {"entity_slept": {"entity_id": 5}}
WOKE = {"entity_woke": {"entity_id": 5}}

SHORT_SECONDS = 0.3
# Far above what a stream takes to notice its end, and far below what a test may take.
PATIENCE_SECONDS = 10.0


def wait(context):
    """Keeps a stream open until its client goes."""
    gone = threading.Event()
    context.add_callback(gone.set)
    gone.wait(PATIENCE_SECONDS)


def lab(server):
    return genphys.connect(server.address).world("lab")


def serving(*answers):
    """A server whose n-th WatchEvents is answered by the n-th of `answers`."""
    calls = iter(answers)
    return FakeServer(WatchEvents=lambda request, context: next(calls)(request, context))


def test_events_come_typed_and_in_order_and_know_names():
    def watch(request, context):
        yield batch(
            1,
            {"entity_created": {"entity": {"id": 5, "display_name": "ball"}}},
            {"contact_began": {"entity_a": 4, "entity_b": 5, "points": [{"depth": 0.25, "normal": {"z": 1}}]}},
            {"sensor_entered": {"sensor_entity": 4, "visitor_entity": 5}},
            {"entity_stopped_moving": {"entity_id": 5, "rotation": True}},
            {"joint_broke": {"joint_id": 3, "force": 2.0}},
            {},
        )

    with serving(watch) as server:
        created, touch, entered, stopped, broke, unknown = list(lab(server).events())

    assert isinstance(created, genphys.EntityCreated) and created.info.name == "ball"
    assert isinstance(touch, genphys.ContactBegan) and touch.points[0].normal == (0, 0, 1)
    assert (str(touch.entity_a), str(touch.entity_b), touch.sequence) == ("entity 4", "ball", 2)
    assert touch.involves(5) and not touch.involves(6)
    assert isinstance(entered, genphys.SensorEntered) and entered.visitor.name == "ball"
    assert isinstance(stopped, genphys.EntityStoppedMoving) and stopped.rotation
    assert isinstance(broke, genphys.JointBroke) and (broke.joint, broke.force) == (3, 2.0)
    assert type(unknown) is genphys.Event
    with pytest.raises(AttributeError):
        touch.step = 3


def test_a_description_is_read_only_when_somebody_asks_for_it(monkeypatch):
    body = {"geometries": [{"shape": {"sphere": {"radius": 0.25}}}]}
    entity = {"id": 5, "display_name": "ball", "rigid_body": body}

    def watch(request, context):
        changed = {"entity": entity, "changed": {"paths": ["pose"]}}
        yield batch(1, {"entity_created": {"entity": entity}}, {"entity_updated": changed})

    read = []
    entity_info = events._decode.entity_info
    monkeypatch.setattr(events._decode, "entity_info", lambda *given: read.append(1) or entity_info(*given))
    with serving(watch) as server:
        created, updated = list(lab(server).events())

    assert (str(created.entity), created.involves(5), updated.changed) == ("ball", True, ("pose",))
    assert not read
    # Once, and the same values from then on, in copies too.
    assert created.info is created.info and len(read) == 1
    assert pickle.loads(pickle.dumps(updated)) == updated == copy.copy(updated) and len(read) == 2
    assert created.info.geometries[0].shape.radius == 0.25 and "radius=0.25" in repr(updated)
    assert dataclasses.replace(created, step=7).info == created.info
    with pytest.raises(AttributeError):
        created.nothing


def test_a_lost_connection_is_taken_up_where_it_broke_and_nothing_comes_twice():
    def breaks(request, context):
        yield batch(1)
        yield batch(1, SLEPT, WOKE)
        context.abort(grpc.StatusCode.UNAVAILABLE, "connection reset")

    def repeats(request, context):
        yield batch(2, WOKE, SLEPT)

    with serving(breaks, repeats) as server:
        stream = lab(server).events()
        sequences = [event.sequence for event in stream]
        first, second = server.received("WatchEvents")

    assert sequences == [1, 2, 3]
    assert not first.HasField("after_sequence")
    assert (second.epoch, second.after_sequence) == (EPOCH, 2)
    assert stream.position == (EPOCH, 3)


def test_a_server_that_comes_back_is_found_again():
    def breaks(request, context):
        yield batch(1, SLEPT)
        wait(context)

    server = serving(breaks)
    stream = lab(server).events()
    assert next(stream).sequence == 1
    server.stop()

    with FakeServer(server.address, WatchEvents=lambda request, context: iter([batch(2, WOKE)])):
        assert [event.sequence for event in stream] == [2]


def test_a_position_of_an_earlier_stream_is_where_the_next_one_goes_on():
    with serving(lambda request, context: iter([batch(9, SLEPT)])) as server:
        assert next(lab(server).events(after=(EPOCH, 8))).sequence == 9
        (request,) = server.received("WatchEvents")

    assert (request.epoch, request.after_sequence) == (EPOCH, 8)


def test_events_that_are_lost_are_said():
    def watch(request, context):
        yield batch(1)
        yield wire.WatchEventsResponse(stamp={"epoch": EPOCH}, gap={"first_sequence": 1, "last_sequence": 6})
        yield batch(7, SLEPT)

    with serving(watch) as server:
        gap, event = list(lab(server).events())

    assert gap == genphys.Gap(1, 6)
    assert event.sequence == 7


def test_a_reset_world_begins_a_new_epoch():
    def watch(request, context):
        yield batch(5, SLEPT)
        yield batch(1, WOKE, epoch=EPOCH + 1)

    with serving(watch) as server:
        slept, reset, woke = list(lab(server).events())

    assert reset == genphys.EpochBegan(EPOCH + 1)
    assert (slept.sequence, woke.sequence) == (5, 1)


def test_history_that_is_gone_is_an_error_and_no_hole():
    def gone(request, context):
        refuse(context, grpc.StatusCode.OUT_OF_RANGE, "HISTORY_GONE", "too far behind")

    with serving(gone) as server, pytest.raises(genphys.HistoryGoneError):
        lab(server).events(after=(EPOCH, 1))


def test_a_stream_without_a_first_message_is_given_up():
    with (
        serving(lambda request, context: iter([wait(context)])) as server,
        genphys.connect(server.address, timeout=SHORT_SECONDS) as client,
        pytest.raises(genphys.DeadlineExceededError, match="no first message"),
    ):
        client.world("lab").events()


def quiet(request, context):
    yield batch(1)
    wait(context)


def test_a_duration_ends_the_iteration():
    with serving(quiet) as server:
        begin = time.monotonic()
        assert list(lab(server).events(duration=SHORT_SECONDS)) == []

    assert SHORT_SECONDS <= time.monotonic() - begin < PATIENCE_SECONDS


@pytest.mark.parametrize("ends", ["stream", "world", "server"])
def test_another_thread_may_end_a_stream_that_waits(ends):
    with serving(quiet) as server:
        client = genphys.connect(server.address)
        world = client.world("lab")
        stream = world.events()
        closer = {"stream": stream, "world": world, "server": client}[ends]
        timer = threading.Timer(SHORT_SECONDS, closer.close)
        timer.start()
        begin = time.monotonic()
        assert list(stream) == []
        timer.join()

    assert time.monotonic() - begin < PATIENCE_SECONDS


def test_frames_are_pushed_with_what_was_asked_for():
    def watch(request, context):
        for step in (2, 4):
            yield wire.WatchFramesResponse(frame={"stamp": {"step": step, "epoch": EPOCH}, "skipped_frames": step})

    with FakeServer(WatchFrames=watch) as server:
        frames = list(lab(server).frames(genphys.FrameRequest(velocities=False), every=2))
        (request,) = server.received("WatchFrames")

    # Both, or what they come to when the second was there before the first was looked at.
    assert frames[-1].step == 4
    assert sum(frame.skipped_frames for frame in frames) + len(frames) == 8
    assert request.every_nth_step == 2
    assert request.frame.poses and not request.frame.velocities


def test_a_keyframe_that_nobody_saw_still_bears_the_deltas_against_it():
    def whole(step, key, heights):
        ids, poses = struct.pack("<2Q", 4, 5), struct.pack("<6d", 0, 0, heights[0], 0, 0, heights[1])
        return {"stamp": {"step": step}, "keyframe_id": key, "rows_id": 1, "entity_ids": ids, "positions": poses}

    def delta(step, key, height):
        changed = {"entity_ids": struct.pack("<Q", 5), "positions": struct.pack("<3d", 0, 0, height)}
        return {"stamp": {"step": step}, "keyframe_id": key, "keyframe_step": 1, "asleep": b"\0", **changed}

    sent = threading.Event()

    def watch(request, context):
        for frame in (whole(0, 7, (1, 2)), delta(1, 7, 3), whole(2, 8, (4, 5)), delta(3, 8, 6)):
            yield wire.WatchFramesResponse(frame=frame)
        sent.set()
        wait(context)

    with FakeServer(WatchFrames=watch) as server, lab(server).frames(genphys.FrameRequest(deltas=True)) as frames:
        assert sent.wait(PATIENCE_SECONDS)
        time.sleep(SHORT_SECONDS)
        newest = next(frames)

    assert (newest.step, newest.skipped_frames, newest.positions[:, 2].tolist()) == (3, 3, [4.0, 6.0])


def test_a_world_that_a_new_server_does_not_have_yet_is_waited_for(monkeypatch):
    def breaks(request, context):
        yield batch(1, SLEPT)
        context.abort(grpc.StatusCode.UNAVAILABLE, "connection reset")

    def has_none(request, context):
        refuse(context, grpc.StatusCode.NOT_FOUND, "WORLD_NOT_FOUND", "there is no world lab")

    with serving(breaks, has_none, has_none, lambda request, context: iter([batch(2, WOKE)])) as server:
        assert [event.sequence for event in lab(server).events()] == [1, 2]
    monkeypatch.setattr(streams, "WORLD_SECONDS", 0.0)
    with serving(breaks, has_none, has_none) as server, pytest.raises(genphys.WorldNotFoundError):
        list(lab(server).events())


def test_a_server_that_cancels_what_comes_while_it_goes_is_as_good_as_none():
    cancels = lambda request, context: context.abort(grpc.StatusCode.CANCELLED, "")  # noqa: E731

    def cancels_later(request, context):
        yield batch(1, SLEPT)
        cancels(request, context)

    with serving(cancels_later, cancels, lambda request, context: iter([batch(2, WOKE)])) as server:
        assert [event.sequence for event in lab(server).events()] == [1, 2]
    with FakeServer(GetWorld=cancels) as server, pytest.raises(genphys.UnavailableError, match="shutting down"):
        lab(server).info()

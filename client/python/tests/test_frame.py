"""Frames are numpy views of the received bytes, addressed by entity."""

import copy
import pickle

import numpy as np
import pytest

import genphys
from genphys._contract import SCALAR, wire
from genphys.frame import DeltaMerger, RowsCache

IDS = [11, 12, 15]


def frame_message(ids=IDS, dtype="<f8", offset=0.0, **fields):
    count = len(ids)
    positions = np.arange(3.0 * count).reshape(count, 3) + offset
    orientations = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
    return wire.Frame(
        stamp={"step": 4, "simulation_time_seconds": 0.5, "epoch": 7},
        scalar=SCALAR.number("float64" if dtype == "<f8" else "float32"),
        rows_id=fields.pop("rows_id", 1),
        entity_ids=np.array(ids, "<u8").tobytes(),
        positions=positions.astype(dtype).tobytes(),
        orientations=orientations.astype(dtype).tobytes(),
        **fields,
    )


def test_columns_have_the_declared_shapes_and_values():
    frame = genphys.Frame(frame_message())

    assert (frame.step, frame.time, frame.epoch, frame.state_hash, len(frame)) == (4, 0.5, 7, None, 3)
    assert frame.ids.tolist() == IDS
    assert frame.positions.tolist() == [[0, 1, 2], [3, 4, 5], [6, 7, 8]]
    assert frame.orientations.shape == (3, 4)
    assert frame.positions.dtype == np.float64


def test_columns_are_read_only_views_that_are_made_once():
    frame = genphys.Frame(frame_message())

    assert frame.positions is frame.positions
    assert not frame.positions.flags.owndata
    assert not frame.positions.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        frame.positions[0, 0] = 1.0


def test_single_precision_stays_single():
    frame = genphys.Frame(frame_message(dtype="<f4"))

    assert frame.positions.dtype == np.float32
    assert frame.positions[2].tolist() == [6, 7, 8]


def test_rows_are_found_by_handle_and_by_id_and_not_guessed():
    frame = genphys.Frame(frame_message())

    assert frame.row(genphys.Entity(12)) == 1
    assert frame.row(15) == 2
    with pytest.raises(KeyError, match="entity 13 is not in this frame"):
        frame.row(13)


def test_a_column_that_was_not_asked_for_says_so():
    frame = genphys.Frame(frame_message())

    with pytest.raises(AttributeError, match="linear_velocities were not asked for"):
        frame.linear_velocities  # noqa: B018


def test_sleepers_are_read_bit_by_bit_from_the_lowest():
    assert genphys.Frame(frame_message(asleep=bytes([0b101]))).asleep.tolist() == [True, False, True]
    assert genphys.Frame(frame_message()).asleep.tolist() == [False, False, False]


def test_rows_that_are_not_sent_again_are_remembered():
    cache = RowsCache()
    first = frame_message()
    again = frame_message()
    again.ClearField("entity_ids")
    other = frame_message(ids=[21, 22], rows_id=2)

    rows = cache.rows_of(first)
    assert len(cache.rows_of(wire.Frame()).ids) == 0

    assert cache.rows_of(again) is rows
    assert genphys.Frame(again, cache.rows_of(again)).row(15) == 2
    assert genphys.Frame(other, cache.rows_of(other)).ids.tolist() == [21, 22]


def test_a_delta_is_laid_over_its_keyframe():
    merger = DeltaMerger()
    keyframe = frame_message(asleep=bytes([0b111]))
    keyframe.keyframe_id = 77
    delta = frame_message(ids=[15], offset=100.0, keyframe_step=4, keyframe_id=77, asleep=bytes([0]))
    delta.stamp.step = 6
    nothing = wire.Frame(stamp={"step": 7}, keyframe_step=4, keyframe_id=77)
    stranger = frame_message(ids=[15], keyframe_step=4, keyframe_id=78)

    merger.merge(genphys.Frame(keyframe), keyframe)
    whole = merger.merge(genphys.Frame(delta), delta)

    assert whole.step == 6
    assert whole.ids.tolist() == IDS
    assert whole.positions.tolist() == [[0, 1, 2], [3, 4, 5], [100, 101, 102]]
    assert whole.asleep.tolist() == [True, True, False]
    same = merger.merge(genphys.Frame(nothing), nothing)
    assert (same.step, same.asleep.tolist(), len(same)) == (7, [True, True, True], 3)
    assert same.positions.tolist() == [[0, 1, 2], [3, 4, 5], [6, 7, 8]]
    assert merger.merge(genphys.Frame(stranger), stranger) is None


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda frame: pickle.loads(pickle.dumps(frame))])
def test_a_frame_can_be_copied_and_pickled(copied):
    cache = RowsCache()
    cache.rows_of(frame_message())
    later = frame_message(offset=1.0, asleep=b"\x02")
    later.ClearField("entity_ids")  # as they come while the rows are the same
    frame = genphys.Frame(later, cache.rows_of(later), wanted=wire.FrameRequest(poses=True))

    other = copied(frame)

    assert type(other) is genphys.Frame
    assert (other.stamp, other.ids.tolist(), len(other)) == (frame.stamp, IDS, 3)
    assert np.array_equal(other.positions, frame.positions)
    assert other.asleep.tolist() == [False, True, False]
    assert other.row(15) == 2
    assert not other.positions.flags.writeable
    with pytest.raises(AttributeError, match="linear_velocities were not asked for"):
        other.linear_velocities  # noqa: B018

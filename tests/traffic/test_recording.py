from dataclasses import fields

import numpy as np
import pytest

from gpsec.errors import GpsecError
from gpsec.traffic.options import resolve_options
from gpsec.traffic.recording import RecordedTraffic, Recording, record
from gpsec.traffic.session import SumoSession
from gpsec.traffic.source import Departure, Frame

from .helpers import ROUTE


class Made:
    """Three frames by hand: two vehicles enter, one leaves and its row is taken at once, all leave."""

    step_s = 0.1
    sumo_s = read_s = 0.0

    def frames(self, duration_s=None):
        def departure(row, name, share=None, sensors=None):
            return Departure(row, name, "Ärzte", "passenger", 4.5, 1.8, 0.1 * row - 3.0, 3.0 * row, share, sensors)

        def frame(step, left, departures, rows):
            front = np.array([[step + 0.1 * row, 1.0 / (row + 3)] for row in rows]).reshape(-1, 2)
            rows = np.array(rows, np.int32)
            lane = rows + np.int32(5)
            return Frame(step, 7.0 + step / 10, left, departures, rows, front, lane, 9 + step, spoofers[step])

        spoofers = [{"van": np.array([[1.0, 2.0], [3.0, 4.0]])}, {}, {"b": np.ones((1, 2)), "a": np.zeros((1, 2))}]
        yield frame(0, [], [departure(0, "a", 0.0, "dsd"), departure(1, "long name")], [0, 1])
        yield frame(1, [0], [departure(0, "a#2", 1.0)], [0, 1])
        yield frame(2, [0, 1], [], [])


def assert_same(found, expected):
    assert len(found) == len(expected)
    for one, other in zip(found, expected, strict=True):
        for field in fields(Frame):
            left, right = getattr(one, field.name), getattr(other, field.name)
            if isinstance(right, np.ndarray):
                assert (left.dtype, left.shape, left.tobytes()) == (right.dtype, right.shape, right.tobytes())
                assert left.flags.writeable
            elif field.name == "spoofers_m":
                assert {plan: at.tolist() for plan, at in left.items()} == {k: at.tolist() for k, at in right.items()}
            else:
                assert left == right
                assert type(left) is type(right)


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "made.npz"
    record(Made(), None).save(path)
    return path


def test_replay_is_what_was_recorded(saved):
    replayed = RecordedTraffic(Recording.load(saved))
    assert replayed.step_s == 0.1
    assert_same(list(replayed.frames()), list(Made().frames()))
    assert replayed.sumo_s == 0.0
    assert replayed.read_s > 0.0


def test_replay_of_sumo_is_byte_identical(scenario, lane_index, tmp_path):
    flow = f'<vType id="car"/><flow id="f" type="car" begin="0" period="3" number="9">{ROUTE}</flow>'
    options = resolve_options(scenario(flow), seed=4)
    with SumoSession(options, lane_index, lambda departure: departure.vehicle_id != "f.2") as session:
        frames = list(session.frames(40.0))
    with SumoSession(options, lane_index, lambda departure: departure.vehicle_id != "f.2") as session:
        recording = record(session, 40.0)
    recording.save(tmp_path / "sumo.npz")
    assert_same(list(RecordedTraffic(Recording.load(tmp_path / "sumo.npz")).frames()), frames)
    assert sum(len(frame.departures) for frame in frames) == 8


@pytest.mark.parametrize(("duration_s", "count"), [(None, 3), (0.0, 0), (0.1, 1), (0.15, 2), (0.3, 3), (60.0, 3)])
def test_replay_for_a_duration_and_again(saved, duration_s, count):
    traffic = RecordedTraffic(Recording.load(saved))
    for _ in range(2):
        assert [frame.step for frame in traffic.frames(duration_s)] == list(range(count))


def test_frames_share_no_memory_with_the_recording(saved):
    recording = Recording.load(saved)
    recording.frame(0).front_m[:] = -1.0
    assert_same([recording.frame(0)], [next(Made().frames())])


def test_recording_without_frames(tmp_path):
    class Nothing(Made):
        def frames(self, duration_s=None):
            return iter(())

    record(Nothing(), None).save(tmp_path / "none.npz")
    assert list(RecordedTraffic(Recording.load(tmp_path / "none.npz")).frames()) == []


def test_save_replaces_a_recording_and_leaves_nothing_else(saved):
    record(Made(), None).save(saved)
    assert [path.name for path in saved.parent.iterdir()] == [saved.name]


def changed(path, **arrays):
    with np.load(path) as archive:
        stored = {name: archive[name] for name in archive.files}
    stored.update(arrays)
    np.savez(path, **{name: array for name, array in stored.items() if array is not None})


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"format": np.array([99])}, r"expected a recording of format 3, found \[99\]"),
        ({"format": None}, "expected a recording of format 3"),
        ({"lane": None}, "other arrays than expected: lane"),
        ({"extra": np.zeros(1)}, "other arrays than expected: extra"),
        ({"start": np.array([0, 2, 9, 4])}, "do not fit together"),
        ({"start": np.array([0, 2, 4, 5])}, "do not fit together"),
        ({"start": np.array([0, 2, 4])}, "do not fit together"),
        ({"front_m": np.zeros(4)}, "do not fit together"),
        ({"sensors": np.array(["dsd"])}, "do not fit together"),
        ({"rows": np.array([None] * 4)}, "broken file"),  # would need pickle
    ],
)
def test_recording_that_does_not_fit_together_is_refused(saved, arrays, message):
    changed(saved, **arrays)
    with pytest.raises(GpsecError, match=message) as raised:
        Recording.load(saved)
    assert str(raised.value).startswith(str(saved))


@pytest.mark.parametrize("keep", [0, 10, 500, -30])
def test_truncated_file_is_refused(saved, keep):
    content = saved.read_bytes()
    saved.write_bytes(content[:keep])
    with pytest.raises(GpsecError, match=r"expected a recording \(npz\)"):
        Recording.load(saved)


@pytest.mark.parametrize("content", [b"step,time\n1,2\n", b"\x93NUMPY\x01\x00"])
def test_file_of_another_kind_is_refused(saved, content):
    saved.write_bytes(content)
    with pytest.raises(GpsecError, match=r"expected a recording \(npz\)"):
        Recording.load(saved)


def test_single_array_file_is_refused(tmp_path):
    np.save(tmp_path / "one.npy", np.zeros(3))
    with pytest.raises(GpsecError, match=r"expected a recording \(npz\)"):
        Recording.load(tmp_path / "one.npy")


def test_missing_file_is_named(tmp_path):
    with pytest.raises(GpsecError, match=r"none.npz: recording not found"):
        Recording.load(tmp_path / "none.npz")

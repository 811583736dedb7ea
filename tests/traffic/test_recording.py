from dataclasses import fields

import numpy as np
import pytest

from gpsec.traffic.options import resolve_options
from gpsec.traffic.recording import RecordedTraffic, record_traffic
from gpsec.traffic.recordingfile import OnNet, load_recording, on_net, save_recording
from gpsec.traffic.session import SumoSession
from gpsec.traffic.source import Departure, Frame

from .helpers import ROUTE

NET = OnNet("of a net", 50)


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
    save_recording(record_traffic(Made(), None), path, NET)
    return path


def test_replay_is_what_was_recorded(saved):
    replayed = RecordedTraffic(load_recording(saved, NET))
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
        recording = record_traffic(session, 40.0)
    net = on_net(options.net_file, len(lane_index))
    save_recording(recording, tmp_path / "sumo.npz", net)
    assert_same(list(RecordedTraffic(load_recording(tmp_path / "sumo.npz", net)).frames()), frames)
    assert sum(len(frame.departures) for frame in frames) == 8


@pytest.mark.parametrize(("duration_s", "count"), [(None, 3), (0.0, 0), (0.1, 1), (0.15, 2), (0.3, 3), (60.0, 3)])
def test_replay_for_a_duration_and_again(saved, duration_s, count):
    traffic = RecordedTraffic(load_recording(saved, NET))
    for _ in range(2):
        assert [frame.step for frame in traffic.frames(duration_s)] == list(range(count))


def test_frames_share_no_memory_with_the_recording(saved):
    recording = load_recording(saved, NET)
    recording.frame(0).front_m[:] = -1.0
    assert_same([recording.frame(0)], [next(Made().frames())])


def test_recording_without_frames(tmp_path):
    class Nothing(Made):
        def frames(self, duration_s=None):
            return iter(())

    save_recording(record_traffic(Nothing(), None), tmp_path / "none.npz", NET)
    assert list(RecordedTraffic(load_recording(tmp_path / "none.npz", NET)).frames()) == []

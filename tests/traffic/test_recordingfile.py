"""Files of recordings: what does not belong to the net, or is damaged, is refused in a sentence."""

import gzip
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gpsec.core.errors import GpsecError
from gpsec.core.version import __version__
from gpsec.traffic.recording import RecordedTraffic, Recording, record_traffic
from gpsec.traffic.recordingfile import OnNet, load_recording, on_net, save_recording

from .test_recording import NET, Made, assert_same, saved

__all__ = ["saved"]


def test_save_replaces_a_recording_and_leaves_nothing_else(saved):
    save_recording(record_traffic(Made(), None), saved, NET)
    assert [path.name for path in saved.parent.iterdir()] == [saved.name]


def changed(path, **arrays):
    with np.load(path) as archive:
        stored = {name: archive[name] for name in archive.files}
    stored.update(arrays)
    np.savez(path, **{name: array for name, array in stored.items() if array is not None})


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"format": np.array([99])}, r"expected a recording of format 4, found 99"),
        ({"format": None}, "expected a recording of format 4, found none"),
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
        load_recording(saved, NET)
    assert str(raised.value).startswith(str(saved))


@pytest.mark.parametrize("keep", [0, 10, 500, -30])
def test_truncated_file_is_refused(saved, keep):
    content = saved.read_bytes()
    saved.write_bytes(content[:keep])
    with pytest.raises(GpsecError, match=r"expected a recording \(npz\)"):
        load_recording(saved, NET)


@pytest.mark.parametrize("content", [b"step,time\n1,2\n", b"\x93NUMPY\x01\x00"])
def test_file_of_another_kind_is_refused(saved, content):
    saved.write_bytes(content)
    with pytest.raises(GpsecError, match=r"expected a recording \(npz\)"):
        load_recording(saved, NET)


def test_single_array_file_is_refused(tmp_path):
    np.save(tmp_path / "one.npy", np.zeros(3))
    with pytest.raises(GpsecError, match=r"expected a recording \(npz\)"):
        load_recording(tmp_path / "one.npy", NET)


def test_missing_file_is_named(tmp_path):
    with pytest.raises(GpsecError, match=r"none.npz: recording not found"):
        load_recording(tmp_path / "none.npz", NET)


@pytest.mark.parametrize("net", [OnNet("of another net", 50), OnNet("of another net", 5)])
def test_a_recording_of_another_net_is_refused(saved, net):
    said = f"of this net, found one of another net .made by gpsec {__version__}"
    with pytest.raises(GpsecError, match=said):
        load_recording(saved, net)


def test_a_net_is_known_by_what_is_in_it(tmp_path):
    for name, content in (("a", b"<net/>"), ("b", b"<net/>"), ("c", b"<net />")):
        (tmp_path / name).write_bytes(content)
    (tmp_path / "d.gz").write_bytes(gzip.compress(b"<net/>"))
    a, b, c, d = (on_net(tmp_path / name, 3) for name in ("a", "b", "c", "d.gz"))
    assert a == b == d != c
    with pytest.raises(GpsecError, match="gone: expected a net"):
        on_net(tmp_path / "gone", 3)


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"lane": np.array([5, 6, 5, 10**6], np.int32)}, "lane: expected 0 to 49, found 1e[+]06"),
        ({"lane": np.array([5, -1, 5, 6], np.int32)}, "lane: expected 0 to 49, found -1"),
        ({"lane": np.array([5, 50, 5, 6], np.int32)}, "lane: expected 0 to 49, found 50"),
        ({"lane": np.array([5, 6, 5, 6], np.int64)}, "lane: expected an array of type i4, found int64"),
        ({"rows": np.array([0, 1, 0, 10**9], np.int32)}, "rows: expected 0 to 2, found 1e[+]09"),
        ({"rows": np.array([0, 1, 0, 2], np.int32)}, "rows of frame 1: expected vehicles that have departed"),
        ({"rows": np.array([1, 0, 0, 1], np.int32)}, "rows of frame 0: expected vehicles that have departed"),
        ({"rows": np.array([0, 0, 0, 1], np.int32)}, "rows of frame 0: expected vehicles that have departed"),
        ({"left": np.array([2, 0, 1], np.int32)}, "rows of frame 1: expected vehicles that have departed"),
        ({"left": np.array([1, 0, 1], np.int32)}, "rows of frame 1: expected vehicles that have departed"),
        ({"departure_row": np.array([0, 0, 0], np.int32)}, "rows of frame 0: expected vehicles that have departed"),
        ({"front_m": np.full((4, 2), np.nan)}, "front_m: expected finite numbers"),
        ({"front_m": np.full((4, 2), 1e300)}, "front_m: expected -1e[+]07 to 1e[+]07, found 1e[+]300"),
        ({"front_m": np.zeros((4, 3))}, "do not fit together"),
        ({"length_m": np.array([4.5, 0.0, 4.5])}, "length_m: expected 0.001 to 1000, found 0"),
        ({"speed_mps": np.array([1.0, -1.0, 4.5])}, "speed_mps: expected 0 to 1000, found -1"),
        ({"equipped_share": np.array([0.0, 2.0, 1.0])}, "equipped_share: expected 0 to 1, found 2"),
        ({"step": np.array([0, 1, 3], np.int32)}, "step: expected one number after the other"),
        ({"time_s": np.array([7.0, 7.2, 7.1])}, "time_s: expected times that grow"),
        ({"step_s": np.array([0.0])}, "step_s: expected 0.001 to 1, found 0"),
        ({"step_s": np.array(0.1)}, "do not fit together"),
        ({"sensors": np.array([0x110000] * 3, np.uint32).view("U1")}, "sensors: expected texts, found letters"),
        ({"sensors": np.array([0xD800] * 3, np.uint32).view("U1")}, "sensors: expected texts, found letters"),
        ({"vehicle_id": np.array(["a", "b", "c"]).astype(">U1")}, "vehicle_id: expected an array of type U"),
        ({"net": np.array([1])}, "found one of another net"),
        ({"net": None}, "found one of another net"),
    ],
)
def test_what_no_traffic_is_made_of_is_refused(saved, arrays, message):
    changed(saved, **arrays)
    with pytest.raises(GpsecError, match=message):
        load_recording(saved, NET)


def loaded_or_refused(path: Path) -> Recording | None:
    try:
        return load_recording(path, NET)
    except GpsecError:
        return None


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.integers(0, 1 << 16), byte=st.integers(0, 255), how=st.sampled_from(["set", "cut", "drop"]))
def test_a_damaged_file_is_what_it_was_or_refused(saved, place, byte, how):
    content = bytearray(saved.read_bytes())
    at = place % len(content)
    if how == "set":
        content[at] = byte
    else:
        del content[at : at + 1 if how == "drop" else None]
    damaged = saved.with_name("damaged.npz")
    damaged.write_bytes(content)
    found = loaded_or_refused(damaged)
    if found is not None:
        assert_same(list(RecordedTraffic(found).frames()), list(Made().frames()))


NAMES = [field.name for field in fields(Recording)]
VALUES = st.sampled_from([-(2**31), -1, 0, 1, 2, 3, 49, 50, 2**30, 2**31 - 1, 0.5, -0.5, 1e300, np.nan, np.inf])


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data(), name=st.sampled_from(NAMES), value=VALUES)
def test_a_value_that_was_changed_can_be_replayed_or_is_refused(saved, data, name, value):
    array = getattr(record_traffic(Made(), None), name).copy()
    how = data.draw(st.sampled_from(["value", "type", "shape", "length"]))
    at = data.draw(st.integers(0, max(array.size - 1, 0)))
    with np.errstate(all="ignore"):
        if how == "value" and array.size and array.dtype.kind != "U":
            array.flat[at] = np.array(value).astype(array.dtype)
        elif how == "type":
            array = np.zeros(array.shape, data.draw(st.sampled_from(["f4", "f8", "i4", "i8", "?", "U3", "c16", ">i4"])))
        elif how == "shape":
            array = array.reshape(data.draw(st.sampled_from([(-1,), (1, -1), (-1, 1)])))
        elif how == "length":
            array = array[: len(array) // 2] if at % 2 else np.concatenate([array, array])
    changed(saved, **{name: array})
    found = loaded_or_refused(saved)
    save_recording(record_traffic(Made(), None), saved, NET)
    if found is not None:
        driving: set[int] = set()
        for frame in RecordedTraffic(found).frames():
            driving -= set(frame.left)
            driving |= {departure.row for departure in frame.departures}
            assert set(frame.rows.tolist()) <= driving <= {0, 1, 2}
            assert ((frame.lane >= 0) & (frame.lane < NET.lanes)).all()
            assert np.isfinite(frame.front_m).all()

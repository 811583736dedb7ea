import json
import re
from dataclasses import fields

import numpy as np
import pytest

from gpsec.core.caches import cache_folder
from gpsec.core.errors import GpsecError
from gpsec.hdmap import map as module
from gpsec.hdmap.map import HDMap, compile_map, load_map

from .nets import BEND, arc, net_text


@pytest.fixture(scope="module")
def bend(plain_net):
    return plain_net(*BEND)


@pytest.fixture
def compiled(monkeypatch) -> list[str]:
    """Names of the nets that were compiled, not read from the cache."""
    seen: list[str] = []
    real = module.compile_map

    def watched(net_file, spacings_m, error):
        seen.append(net_file.name)
        return real(net_file, spacings_m, error)

    monkeypatch.setattr(module, "compile_map", watched)
    return seen


def assert_equal(one: HDMap, other: HDMap) -> None:
    assert one.lane_ids == other.lane_ids
    assert one.points == other.points
    assert one.spacings_m == other.spacings_m
    assert one.projector == other.projector
    assert one.stretched == other.stretched
    for group in ("lanes", "index", "sides", "graph"):
        for name, array in getattr(one, group)._asdict().items():
            twin = getattr(getattr(other, group), name)
            assert (array.dtype, array.shape, array.tobytes()) == (twin.dtype, twin.shape, twin.tobytes()), name
            assert type(array) is type(twin) is np.ndarray
            assert array.flags.c_contiguous
    assert len(fields(HDMap)) == 9


def test_true_layer_is_the_net_itself(bend):
    hd_map = compile_map(bend, (2.0, 5.0))
    for lane_id, lane in hd_map.lane_index.items():
        shape = re.search(rf'<lane id="{lane_id}".*?shape="([^"]*)"', net_text(bend)).group(1)
        expected = [[float(number) for number in point.split(",")] for point in shape.split()]
        assert hd_map.centre_line(lane) == pytest.approx(np.array(expected))


def test_layers_are_resampled_at_their_spacing(bend):
    hd_map = compile_map(bend, (2.0, 5.0))
    assert (hd_map.layer(2.0), hd_map.layer(5.0)) == (1, 2)
    for lane in range(len(hd_map.lane_ids)):
        length = np.hypot(*np.diff(hd_map.centre_line(lane), axis=0).T).sum()
        for spacing in (2.0, 5.0):
            points = hd_map.centre_line(lane, hd_map.layer(spacing))
            assert len(points) == np.ceil(length / spacing - 1e-9) + 1
            assert points[[0, -1]] == pytest.approx(hd_map.centre_line(lane)[[0, -1]])
    assert (hd_map.lanes.length_m > 0.0).all()


def test_ends_that_nothing_is_joined_to_are_open(bend):
    hd_map = compile_map(bend, (5.0,))
    lanes = hd_map.lanes
    for layer in (0, 1):
        for lane_id, lane in hd_map.lane_index.items():
            first, count = lanes.first[layer, lane], lanes.segments[layer, lane]
            assert lanes.open_start[first] == (lane_id == "ab_0")
            assert lanes.open_end[first + count - 1] == (lane_id in {"bc_0", "bd_0"})
            assert not lanes.open_start[first + 1 : first + count].any()
            assert not lanes.open_end[first : first + count - 1].any()


def test_direction_and_curvature_of_an_arc(plain_net):
    hd_map = compile_map(plain_net(*arc(30.0, left=False)), ())
    lanes = hd_map.lanes
    middle = lanes.yaw0_rad + 0.5 * lanes.turn_rad
    # The net has six decimals, and its points are 0.04 m apart.
    assert middle == pytest.approx(np.arctan2(lanes.dy, lanes.dx), abs=5e-5)
    assert lanes.curvature0_per_m == pytest.approx(np.full(len(middle), -1.0 / 30.0), rel=1e-4)


def test_second_load_is_the_first(bend, tmp_path, compiled):
    first = load_map(bend, (5.0, 2.0, 5.0), tmp_path)
    second = load_map(bend, (2.0, 5.0), tmp_path)
    assert compiled == ["made.net.xml"]
    assert second.spacings_m == (2.0, 5.0)
    assert_equal(first, second)
    assert_equal(second, compile_map(bend, (2.0, 5.0)))


def test_loaded_arrays_cannot_change_the_cache(bend, tmp_path):
    load_map(bend, (), tmp_path)
    load_map(bend, (), tmp_path).lanes.x0_m[:] = 0.0
    assert_equal(load_map(bend, (), tmp_path), compile_map(bend, ()))


def test_other_spacings_and_a_changed_net_are_compiled_again(bend, tmp_path, compiled):
    net = tmp_path / "net.net.xml"
    net.write_text(net_text(bend))
    load_map(net, (5.0,), tmp_path)
    load_map(net, (2.0,), tmp_path)
    assert len(compiled) == 2
    net.write_text(net_text(bend).replace('speed="13.900000"', 'speed="12.000000"'))
    load_map(net, (2.0,), tmp_path)
    assert len(compiled) == 3
    net.write_text(net_text(bend))
    load_map(net, (2.0,), tmp_path)
    assert len(compiled) == 3


DAMAGES = {
    "array missing": ("MapArrays.x0_m.npy", None),
    "array empty": ("MapArrays.x0_m.npy", b""),
    "array cut off": ("MatchIndex.grid_chunk.npy", -8),
    "array of text": ("LaneSides.width_m.npy", b"widths"),
    "names missing": ("net.json", None),
    "names empty": ("net.json", b""),
    "names cut off": ("net.json", -3),
    "names of another kind": ("net.json", b"[]"),
    "names without a key": ("net.json", b'{"lane_ids": []}'),
    "names not text": ("net.json", b"\xff\xfe\x00"),
    "digests missing": ("SHA256SUMS", None),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_cache_is_compiled_again(bend, tmp_path, compiled, damage):
    expected = load_map(bend, (5.0,), tmp_path)
    name, change = DAMAGES[damage]
    (path,) = tmp_path.rglob(name)
    if change is None:
        path.unlink()
    else:
        path.write_bytes(path.read_bytes()[:change] if isinstance(change, int) else change)
    assert_equal(load_map(bend, (5.0,), tmp_path), expected)
    assert len(compiled) == 2


@pytest.mark.parametrize("name", ["MapArrays.x0_m.npy", "MatchIndex.grid_chunk.npy", "net.json", "SHA256SUMS"])
def test_one_flipped_bit_is_mended(bend, tmp_path, compiled, name):
    expected = load_map(bend, (5.0,), tmp_path)
    (path,) = tmp_path.rglob(name)
    content = bytearray(path.read_bytes())
    content[-9] ^= 4  # within a number, or a name
    path.write_bytes(content)
    assert_equal(load_map(bend, (5.0,), tmp_path), expected)
    assert len(compiled) == 2
    assert_equal(load_map(bend, (5.0,), tmp_path), expected)
    assert len(compiled) == 2


def test_the_cache_holds_no_half_map(bend, tmp_path):
    load_map(bend, (5.0,), tmp_path)
    (folder,) = (tmp_path / "maps").iterdir()
    assert set(json.loads((folder / "net.json").read_text())) == {
        "lane_ids",
        "points",
        "projection",
        "offset_m",
        "spacings_m",
        "stretched",
    }


def test_the_cache_is_where_the_environment_says(monkeypatch, tmp_path):
    monkeypatch.setenv("GPSEC_CACHE", str(tmp_path / "kept"))
    assert cache_folder() == tmp_path / "kept"
    monkeypatch.delenv("GPSEC_CACHE")
    assert cache_folder().parts[-2:] == (".cache", "gpsec")


def test_a_missing_net_is_named(tmp_path):
    with pytest.raises(GpsecError, match=r"none\.net\.xml: no such net file"):
        load_map(tmp_path / "none.net.xml", (), tmp_path)
    assert not list(tmp_path.iterdir())

"""Maps in vehicles that are not where the roads are."""

from math import exp

import numpy as np
import pytest

from gpsec.hdmap.error import EXACT, MapError
from gpsec.hdmap.map import compile_map, load_map
from gpsec.hdmap.polyline import measure
from gpsec.hdmap.search import NEAREST, TRACKED
from tests.hdmap.nets import BEND, TWO_WAY, match


@pytest.fixture(scope="module")
def town(repository):
    return repository / "sumo_nets" / "town" / "town.net.xml"


def lines(hd_map, layer):
    return {lane: hd_map.centre_line(number, layer) for number, lane in enumerate(hd_map.lane_ids)}


def across(true, moved):
    """Return how far left of each point of `true` that of `moved` lies, and how far along the lane."""
    way = np.diff(true, axis=0)[0]
    left = np.array([-way[1], way[0]]) / np.hypot(*way)
    return (moved - true) @ left, (moved - true) @ way / np.hypot(*way)


def test_an_exact_map_keeps_every_byte(town):
    plain, zero = compile_map(town, (2.0,)), compile_map(town, (2.0,), MapError(seed=7))
    for mine, theirs in zip((*plain.lanes, *plain.index), (*zero.lanes, *zero.index), strict=True):
        assert mine.tobytes() == theirs.tobytes()


def test_the_roads_themselves_stay_where_they_are(town):
    plain, moved = compile_map(town, (2.0,)), compile_map(town, (2.0,), MapError(1, (0.3, 0.1), 0.2, 100.0, 0.1))
    for lane, line in lines(plain, 0).items():
        np.testing.assert_array_equal(line, lines(moved, 0)[lane])


def test_a_shift_is_that_of_the_whole_map(town):
    plain, moved = compile_map(town, (2.0,)), compile_map(town, (2.0,), MapError(shift_m=(0.3, -0.1)))
    there = lines(moved, 1)
    for lane, line in lines(plain, 1).items():
        np.testing.assert_allclose(there[lane] - line, np.tile([0.3, -0.1], (len(line), 1)), atol=1e-6)


@pytest.mark.parametrize("mode", [TRACKED, NEAREST])
def test_what_is_matched_is_off_by_the_shift(plain_net, mode):
    net = plain_net(*TWO_WAY)
    plain, moved = compile_map(net, (2.0,)), compile_map(net, (2.0,), MapError(shift_m=(0.0, 0.2)))
    _, stated = match(plain, mode, "ab_0", 100.0, -4.0, 0.0, layer=1)
    _, found = match(moved, mode, "ab_0", 100.0, -4.0, 0.0, layer=1)
    assert found == pytest.approx(stated - 0.2, abs=1e-6)
    assert match(moved, mode, "ab_0", 100.0, -4.0, 0.0, layer=0)[1] == pytest.approx(stated, abs=1e-6)


def test_a_search_finds_what_has_moved(town):
    """The circles that skip what is too far hold the moved lanes: against a look at all segments."""
    moved = compile_map(town, (2.0,), MapError(3, (1.0, 1.0), 0.5, 50.0, 0.5))
    draws = np.random.default_rng(4)
    first, looked_at = moved.lanes.first[1, 0], 0
    for number in draws.integers(0, len(moved.lane_ids), 50):
        lane = moved.lane_ids[number]
        line = moved.centre_line(number, 1)
        x, y = line[len(line) // 2] + draws.normal(0.0, 2.0, 2)
        heading = measure(line).yaw_rad[len(line) // 2]
        segment, _ = match(moved, TRACKED, lane, x, y, heading, layer=1)
        if segment < 0:
            continue  # beside a curve
        looked_at += 1
        index, lanes = moved.index, moved.lanes
        chain = index.chain_lane[index.chain_first[number] : index.chain_first[number] + index.chain_count[number]]
        mine = np.isin(lanes.lane, chain) & (np.arange(len(lanes.lane)) >= first)
        mine &= lanes.dx * np.cos(heading) + lanes.dy * np.sin(heading) >= 0.0
        rx, ry = x - lanes.x0_m, y - lanes.y0_m
        along = rx * lanes.dx + ry * lanes.dy
        low = np.where(lanes.open_start, -np.inf, 0.0)
        high = np.where(lanes.open_end, np.inf, lanes.length_m)
        held = np.clip(along, low, high)
        d2 = np.where(mine, (rx - held * lanes.dx) ** 2 + (ry - held * lanes.dy) ** 2, np.inf)
        assert d2[segment] == pytest.approx(d2.min(), abs=1e-9)
    assert looked_at > 40


def test_a_road_has_a_draw_of_its_own_and_lanes_of_a_road_share_it(town):
    size_m = 0.1
    plain, moved = compile_map(town, (5.0,)), compile_map(town, (5.0,), MapError(seed=5, road_m=size_m))
    there, found = lines(moved, 1), {}
    for lane, line in lines(plain, 1).items():
        if not lane.startswith(":"):
            left_m, along_m = across(line[:2], there[lane][:2])
            assert np.abs(along_m).max() < 0.05  # the direction at the end of a curve is that of half a segment
            found.setdefault(lane.rpartition("_")[0], []).append(left_m[0])
    draws = np.array([values[0] for values in found.values()])
    assert all(np.ptp(values) < 0.005 for values in found.values())
    assert np.std(draws) == pytest.approx(size_m, rel=4.0 / np.sqrt(2.0 * len(draws)))
    assert abs(np.mean(draws)) < 4.0 * size_m / np.sqrt(len(draws))


def test_inside_a_junction_one_road_passes_into_the_next(plain_net):
    moved = lines(compile_map(plain_net(*BEND), (1.0,), MapError(seed=5, road_m=0.5)), 1)
    stated = lines(compile_map(plain_net(*BEND), (1.0,)), 1)
    left_m = {lane: across(stated[lane][:2], moved[lane][:2])[0][0] for lane in ("ab_0", "bc_0", "bd_0")}
    assert min(abs(left_m["ab_0"] - left_m[out]) for out in ("bc_0", "bd_0")) > 0.2
    internal = [lane for lane in moved if lane.startswith(":b")]
    for lane in internal:
        gaps = (
            np.hypot(*(moved["ab_0"][-1] - moved[lane][0]).T),
            min(np.hypot(*(moved[out][0] - moved[lane][-1])) for out in ("bc_0", "bd_0")),
        )
        assert max(gaps) < 0.1


def test_a_field_has_its_size_and_its_correlation_length():
    points = np.random.default_rng(1).uniform(0.0, 200_000.0, (2_000, 2))
    pairs = []
    for seed in range(8):
        error = MapError(seed=seed, field_m=0.2, field_length_m=150.0)
        pairs.append(np.concatenate([error._field(points), error._field(points + np.array([150.0, 0.0]))], axis=1))
    found = np.concatenate(pairs)
    assert np.std(found) == pytest.approx(0.2, rel=0.06)
    assert np.corrcoef(found[:, 0], found[:, 2])[0, 1] == pytest.approx(exp(-0.5), abs=0.1)
    assert abs(np.corrcoef(found[:, 0], found[:, 1])[0, 1]) < 0.1


def test_the_cache_keeps_maps_of_different_errors_apart(plain_net, tmp_path):
    net = plain_net(*BEND)
    exact, off = load_map(net, (2.0,), tmp_path), load_map(net, (2.0,), tmp_path, MapError(shift_m=(1.0, 0.0)))
    assert off.centre_line(0, 1)[0, 0] == pytest.approx(exact.centre_line(0, 1)[0, 0] + 1.0)
    again = load_map(net, (2.0,), tmp_path, EXACT)
    np.testing.assert_array_equal(again.lanes.x0_m, exact.lanes.x0_m)

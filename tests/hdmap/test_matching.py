from math import cos, hypot, pi, radians, sin
from pathlib import Path

import numpy as np
import pytest
import shapely
import sumolib
from hypothesis import given, settings
from hypothesis import strategies as st

from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.pairing import Pending, Sampling
from gpsec.detection.residual import Residuals
from gpsec.hdmap.arrays import MapView
from gpsec.hdmap.locating import locate
from gpsec.hdmap.map import HDMap, compile_map
from gpsec.hdmap.search import MIN_COS, NEAREST, TRACKED
from gpsec.types.camera import NO_MISTAKES
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

from .nets import BEND, THREE_LANES, TWO_WAY, arc, match, segment_line

REACH_M = 100.0  # the documented reach of a chain
NEAR_M = 64.0  # within four cells of 16 m, nearest matching finds everything


@pytest.fixture(scope="module")
def sharp_turns(repository) -> Path:
    return repository / "sumo_nets" / "sharp_turns" / "sharp_turns.net.xml"


@pytest.fixture(scope="module")
def hd_map(sharp_turns) -> HDMap:
    return compile_map(sharp_turns, (2.0, 5.0))


@pytest.fixture(scope="module")
def two_way(plain_net) -> HDMap:
    return compile_map(plain_net(*TWO_WAY), ())


@pytest.fixture(scope="module")
def bend(plain_net) -> HDMap:
    return compile_map(plain_net(*BEND), ())


@pytest.fixture(scope="module")
def wide(plain_net) -> HDMap:
    return compile_map(plain_net(*THREE_LANES), ())


class Brute:
    """Every candidate segment measured by shapely."""

    def __init__(self, net_file: Path, hd_map: HDMap) -> None:
        self.map = hd_map
        lanes = hd_map.lanes
        count = len(lanes.lane)
        self.closed = np.array([segment_line(lanes, s, extend=False) for s in range(count)])
        self.drawn_out = np.array([segment_line(lanes, s, extend=True) for s in range(count)])
        net = sumolib.net.readNet(str(net_file), withInternal=True)
        self.after = {name: set() for name in hd_map.lane_ids}
        for lane in hd_map.lane_ids:
            for way in net.getLane(lane).getOutgoing():
                self.after[lane].add(way.getViaLaneID() or way.getToLane().getID())
        self.before = {name: {a for a, to in self.after.items() if name in to} for name in self.after}
        self.chains = {name: self._chain(name) for name in hd_map.lane_ids}

    def _chain(self, lane: str) -> set[str]:
        """The lane and all that begin less than the reach from its ends, by relaxation until nothing changes."""
        found = {lane}
        for links in (self.before, self.after):
            gap = dict.fromkeys(links[lane], 0.0)
            changed = True
            while changed:
                changed = False
                for name in list(gap):
                    length = shapely.LineString(self.map.centre_line(self.map.lane_index[name])).length
                    for following in links[name]:
                        distance = gap[name] + length
                        if distance <= REACH_M and distance < gap.get(following, np.inf):
                            gap[following] = distance
                            changed = True
            found |= set(gap)
        return found

    def segments(self, layer: int, lanes: set[str]) -> np.ndarray:
        first, count = self.map.lanes.first[layer], self.map.lanes.segments[layer]
        runs = [np.arange(first[i], first[i] + count[i]) for i in sorted(self.map.lane_index[name] for name in lanes)]
        return np.concatenate(runs)

    def tracked(self, layer: int, lane: str, point: shapely.Point, heading: float) -> float:
        """Distance to what leads the way of the heading in the chain, infinite where nothing does."""
        chain = self.segments(layer, self.chains[lane])
        leads = self.map.lanes.dx[chain] * cos(heading) + self.map.lanes.dy[chain] * sin(heading) >= 0.0
        return float(shapely.distance(self.drawn_out[chain[leads]], point).min(initial=np.inf))

    def nearest(self, layer: int, point: shapely.Point, heading: float) -> float:
        """Distance to the nearest segment whose direction at its nearest point is within the gate."""
        lanes, every = self.map.lanes, self.segments(layer, set(self.map.lane_ids))
        share = shapely.line_locate_point(self.closed[every], point) / lanes.length_m[every]
        yaw = lanes.yaw0_rad[every] + share * lanes.turn_rad[every]
        distance = shapely.distance(self.closed[every], point)
        return float(np.where(np.cos(heading - yaw) >= MIN_COS, distance, np.inf).min())


@pytest.fixture(scope="module")
def brute(sharp_turns, hd_map) -> Brute:
    return Brute(sharp_turns, hd_map)


# Where on the net: lane, along it, metres beside and beyond, and turned by how much.
places = st.tuples(
    st.integers(0, 10**6),
    st.floats(-0.3, 1.3),
    st.floats(-40.0, 40.0) | st.floats(-2.0, 2.0),
    st.floats(-pi, pi),
    st.sampled_from([0, 1, 2]),
)


def put(hd_map: HDMap, place) -> tuple[str, float, float, float, int]:
    number, share, beside, turned, layer = place
    lane = number % len(hd_map.lane_ids)
    points = hd_map.centre_line(lane)
    line = shapely.LineString(points)
    at = line.interpolate(min(max(share, 0.0), 1.0), normalized=True)
    unit = points[-1] - points[0]
    unit = unit / hypot(*unit)
    beyond = (share - min(max(share, 0.0), 1.0)) * line.length
    x = at.x + beyond * unit[0] - beside * unit[1]
    y = at.y + beyond * unit[1] + beside * unit[0]
    return hd_map.lane_ids[lane], x, y, float(np.arctan2(unit[1], unit[0])) + turned, layer


@settings(max_examples=80)
@given(place=places)
def test_tracked_is_the_nearest_of_the_chain(hd_map, brute, place):
    lane, x, y, heading, layer = put(hd_map, place)
    segment, offset = match(hd_map, TRACKED, lane, x, y, heading, layer)
    expected = brute.tracked(layer, lane, shapely.Point(x, y), heading)
    if segment < 0:  # heading and lane are more than 60° apart
        assert offset == 0.0
        return
    assert hd_map.lane_ids[hd_map.lanes.lane[segment]] in brute.chains[lane]
    assert brute.drawn_out[segment].distance(shapely.Point(x, y)) == pytest.approx(expected, abs=1e-7)
    assert expected - 1e-7 <= abs(offset) <= 2.0 * expected + 1e-7


@settings(max_examples=150)
@given(place=places)
def test_nearest_is_the_nearest_of_all_lanes_within_the_gate(hd_map, brute, place):
    lane, x, y, heading, layer = put(hd_map, place)
    segment, offset = match(hd_map, NEAREST, lane, x, y, heading, layer)
    expected = brute.nearest(layer, shapely.Point(x, y), heading)
    if segment < 0:
        assert expected > NEAR_M - 1e-7
        return
    assert brute.closed[segment].distance(shapely.Point(x, y)) == pytest.approx(expected, abs=1e-9)
    assert expected - 1e-9 <= abs(offset) <= 2.0 * expected + 1e-9


def residual(hd_map, mode, lane, x, y, heading, layer, hint, c0=0.0) -> tuple[int, float, bool]:
    """Segment, residual and whether there is one, of one fix."""
    vehicles, seen, tracks = Table(Vehicles, 1).now, Table(Measurements, 1).now, Table(Tracks, 1).now
    tracks.lane[:], tracks.lane_known[:] = hd_map.lane_index[lane], True
    tracks.vehicle[:] = 0
    tracks.fix_m[:], tracks.fix_valid[:], tracks.segment[:] = (x, y), True, hint
    seen.heading_rad[:], seen.camera_valid[:], seen.lane_poly[:, 0] = heading, True, c0
    run(hd_map, mode, np.array([layer], np.int32), vehicles, seen, tracks, np.zeros(1, np.int32))
    return int(tracks.segment[0]), float(tracks.residual_m[0]), bool(tracks.residual_valid[0])


def run(hd_map, mode, layer, vehicles, seen, tracks, rows) -> None:
    residuals = Residuals(MapView(hd_map.lanes, hd_map.index, mode, layer), Sampling.of(0.1, [10.0] * 2, [10.0] * 2))
    residuals.update(0, Table(Pending, len(tracks.vehicle)).now, rows, tracks, vehicles, seen, Threads(1))


@settings(max_examples=100)
@given(place=places, hints=st.lists(st.integers(0, 10**6), max_size=4))
def test_a_hint_never_changes_the_result(hd_map, place, hints):
    lane, x, y, heading, layer = put(hd_map, place)
    expected = residual(hd_map, TRACKED, lane, x, y, heading, layer, -1)
    at = hd_map.lane_index[lane]
    first, count = hd_map.lanes.first[layer, at], hd_map.lanes.segments[layer, at]
    everywhere = [hint % len(hd_map.lanes.lane) for hint in hints]
    on_the_lane = [first + hint % count for hint in hints]
    for hint in (first, first + count - 1, expected[0], *everywhere, *on_the_lane):
        assert residual(hd_map, TRACKED, lane, x, y, heading, layer, hint) == expected


@pytest.mark.parametrize("mode", [TRACKED, NEAREST])
@pytest.mark.parametrize("offset", [-1.2, -0.3, 0.0, 0.4, 1.5])
def test_left_of_the_lane_is_positive(two_way, mode, offset):
    assert match(two_way, mode, "ab_1", 90.0, -1.6 + offset, 0.0)[1] == pytest.approx(offset)
    assert match(two_way, mode, "ba_0", 90.0, 1.6 - offset, pi)[1] == pytest.approx(offset)


@pytest.mark.parametrize("degrees", [-59.0, -30.0, 0.0, 10.0, 59.0])
def test_offset_is_stretched_by_the_cosine_of_eq_6(two_way, degrees):
    _, offset = match(two_way, TRACKED, "ab_1", 90.0, -1.1, radians(degrees))
    assert offset == pytest.approx(0.5 / cos(radians(degrees)))


@pytest.mark.parametrize("mode", [TRACKED, NEAREST])
@pytest.mark.parametrize(("degrees", "matched"), [(59.9, True), (60.1, False), (-60.1, False), (119.9, False)])
def test_no_match_beyond_60_degrees(two_way, mode, degrees, matched):
    segment, offset = match(two_way, mode, "ab_1", 90.0, -1.1, radians(degrees))
    assert (segment >= 0) == matched
    assert (offset != 0.0) == matched


def test_an_oncoming_lane_is_not_the_nearest_one(two_way):
    # Eastbound at y = 1.9: 0.3 m north of the centre of the westbound lane, 3.5 m north of that of the inner own lane.
    segment, offset = match(two_way, NEAREST, "ab_1", 90.0, 1.9, 0.0)
    assert two_way.lane_ids[two_way.lanes.lane[segment]] == "ab_1"
    assert offset == pytest.approx(3.5)


def test_aliasing_of_the_nearest_lane(wide):
    """A bias of 2.4 m on lanes of 3.2 m reads -0.8 m under nearest matching."""
    # Lanes are 3.2 m apart from y = -8 to y = -1.6; the vehicle is in the middle of the right one.
    fix_y = -8.0 + 2.4
    assert match(wide, TRACKED, "ab_0", 500.0, fix_y, 0.0)[1] == pytest.approx(2.4)
    segment, offset = match(wide, NEAREST, "ab_0", 500.0, fix_y, 0.0)
    assert offset == pytest.approx(-0.8)
    assert wide.lane_ids[wide.lanes.lane[segment]] == "ab_1"
    # One lane width is not to be seen at all.
    assert match(wide, NEAREST, "ab_0", 500.0, -8.0 + 3.2, 0.0)[1] == pytest.approx(0.0, abs=1e-9)
    assert match(wide, TRACKED, "ab_0", 500.0, -8.0 + 3.2, 0.0)[1] == pytest.approx(3.2)


@pytest.mark.parametrize("bias", [-2.0, -0.4, 0.0, 0.4, 2.4])
@pytest.mark.parametrize("true_offset", [-0.3, 0.0, 0.2])
def test_residual_of_a_known_bias_to_the_left_is_minus_the_bias(wide, bias, true_offset):
    """The camera sees the lane centre C0 to the left of a vehicle that is -C0 left of it."""
    _, z, valid = residual(wide, TRACKED, "ab_1", 500.0, -4.8 + true_offset + bias, 0.0, 0, -1, c0=-true_offset)
    assert valid
    assert z == pytest.approx(-bias)


def test_no_residual_without_fix_or_camera_or_match_or_where_the_lane_is_unknown(wide):
    vehicles, seen, tracks = Table(Vehicles, 5).now, Table(Measurements, 5).now, Table(Tracks, 5).now
    tracks.lane[:], tracks.lane_known[:] = wide.lane_index["ab_1"], [True, True, True, True, False]
    tracks.vehicle[:] = np.arange(5)
    tracks.fix_m[:] = 500.0, -4.0
    tracks.fix_valid[:] = [True, False, True, True, True]
    tracks.segment[:] = 1
    tracks.residual_m[:] = 9.0
    tracks.residual_valid[:] = True
    seen.camera_valid[:] = [True, True, False, True, True]
    seen.heading_rad[3] = radians(70.0)
    run(wide, TRACKED, np.zeros(1, np.int32), vehicles, seen, tracks, np.arange(5, dtype=np.int32))
    assert tracks.residual_valid.tolist() == [True, False, False, False, False]
    assert tracks.residual_m == pytest.approx([-0.8, 0.0, 0.0, 0.0, 0.0])
    # A lane that is seen, and a fix that lies on none of the vehicle's way, are evidence.
    assert tracks.unmatched.tolist() == [False, False, False, True, False]


@pytest.mark.parametrize("beyond", [-30.0, -4.0, -0.1, 200.1, 204.0, 260.0])
def test_an_open_end_goes_on_straight_when_tracked(two_way, beyond):
    assert match(two_way, TRACKED, "ab_1", beyond, -1.3, 0.0)[1] == pytest.approx(0.3)
    leaked = hypot(0.3, min(abs(beyond), abs(beyond - 200.0)))
    assert match(two_way, NEAREST, "ab_1", beyond, -1.3, 0.0)[1] == pytest.approx(leaked)


def test_no_along_track_error_leaks_in_where_lanes_are_joined(bend):
    inside = next(n for n in bend.lane_ids if n.startswith(":") and bend.centre_line(bend.lane_index[n])[-1, 1] < 0.0)
    straight = bend.centre_line(bend.lane_index[inside])
    end = straight[0, 0]
    for along in (-4.0, -0.5, 0.5, 4.0, 30.0):
        for lane in ("ab_0", inside, "bd_0"):
            x = end + along
            # To the right, away from the lane that turns off to the left.
            assert match(bend, TRACKED, lane, x, -1.6 - 0.25, 0.0)[1] == pytest.approx(-0.25), (lane, along)


def test_behind_the_bend_the_chain_turns_with_the_lane(bend):
    end = bend.centre_line(bend.lane_index["bc_0"])[0]
    segment, offset = match(bend, TRACKED, "ab_0", end[0] - 0.4, end[1] + 6.0, pi / 2)
    assert bend.lane_ids[bend.lanes.lane[segment]] == "bc_0"
    assert offset == pytest.approx(0.4)


@pytest.mark.parametrize("left", [True, False])
@pytest.mark.parametrize(("radius", "spacing"), [(25.0, 2.0), (25.0, 5.0), (80.0, 5.0)])
def test_a_sparse_map_of_a_curve_misses_by_the_chord_error(plain_net, left, radius, spacing):
    """In the middle of a chord the stored lane lies s²/8R inside the curve, on the side that it turns to."""
    circle = compile_map(plain_net(*arc(radius, left)), (spacing,))
    side = 1.0 if left else -1.0
    chord = float(circle.lanes.length_m[circle.lanes.first[1, 0] + 1])
    pieces = int(circle.lanes.segments[1, 0])
    for piece in (1, pieces // 2, pieces - 2):
        angle = (piece + 0.5) * (pi / 2) / pieces
        x, y, heading = radius * sin(angle), side * radius * (1.0 - cos(angle)), side * angle
        _, z, valid = residual(circle, TRACKED, "ab_0", x, y, heading, 1, -1)
        assert valid
        assert z == pytest.approx(side * chord**2 / (8.0 * radius), rel=5e-3)
        assert residual(circle, TRACKED, "ab_0", x, y, heading, 0, -1)[1] == pytest.approx(0.0, abs=1e-4)


def place(hd_map, vehicles) -> None:
    """Place every row of `vehicles` on the true lanes."""
    rows = np.arange(len(vehicles.lane), dtype=np.int32)
    locate(rows, 0, 0.1, hd_map.roads(np.zeros(1, np.int32)), NO_MISTAKES, vehicles)


@pytest.mark.parametrize("left", [True, False])
def test_truth_on_a_circle(plain_net, left):
    """Lane direction, curvature and offset of rear axles beside a circle of known radius."""
    radius, side = 30.0, 1.0 if left else -1.0
    circle = compile_map(plain_net(*arc(radius, left)), ())
    angle, offset = np.linspace(0.2, 1.3, 12), np.linspace(-1.4, 1.4, 12)
    out = radius - side * offset  # left of a left curve is nearer to its centre
    vehicles = Table(Vehicles, 12).now
    vehicles.lane[:] = 0
    vehicles.rear_m[:] = np.stack([out * np.sin(angle), side * (radius - out * np.cos(angle))], axis=1)
    vehicles.yaw_rad[:] = side * angle
    place(circle, vehicles)
    assert vehicles.lane_offset_m == pytest.approx(offset, abs=1e-4)
    assert vehicles.lane_yaw_rad == pytest.approx(side * angle, abs=1e-4)
    assert vehicles.camera_curvature_per_m == pytest.approx(np.full(12, side / radius), rel=1e-3)
    assert vehicles.lane_width_m.tolist() == [3.2] * 12
    assert vehicles.marked.all()


def test_nothing_is_marked_while_one_end_of_the_vehicle_is_inside_a_junction(bend):
    inside = next(n for n in bend.lane_ids if n.startswith(":"))
    entry = bend.centre_line(bend.lane_index["ab_0"])[-1, 0]
    vehicles = Table(Vehicles, 3).now
    vehicles.lane[:] = [bend.lane_index[name] for name in ("ab_0", inside, "ab_0")]
    vehicles.rear_m[:] = [[entry - 9.0, -1.6], [entry - 2.0, -1.6], [entry + 1.0, -1.6]]
    place(bend, vehicles)
    assert vehicles.marked.tolist() == [True, False, False]


def test_rows_do_not_depend_on_each_other(hd_map):
    rng = np.random.default_rng(7)
    count = 300
    vehicles, seen, tracks = Table(Vehicles, count).now, Table(Measurements, count).now, Table(Tracks, count).now
    for row in range(count):
        place = rng.integers(10**6), rng.uniform(0.0, 1.0), rng.normal(), 0.0, 0
        lane, *tracks.fix_m[row], seen.heading_rad[row], _ = put(hd_map, place)
        tracks.lane[row] = hd_map.lane_index[lane]
    tracks.lane_known[:] = True
    vehicles.profile[:] = rng.integers(0, 2, count)
    tracks.vehicle[:] = np.arange(count)
    tracks.fix_valid[:] = seen.camera_valid[:] = True
    layer = np.array([1, 2], np.int32)
    for mode in [TRACKED, NEAREST]:
        tracks.residual_m[:] = 0.0
        run(hd_map, mode, layer, vehicles, seen, tracks, np.arange(count, dtype=np.int32))
        together = tracks.residual_m.copy()
        assert tracks.residual_valid.mean() > 0.8
        tracks.residual_m[:] = 0.0
        for row in rng.permutation(count):
            run(hd_map, mode, layer, vehicles, seen, tracks, np.array([row], np.int32))
        assert tracks.residual_m.tobytes() == together.tobytes()

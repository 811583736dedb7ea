"""Where vehicles stand, and who drives on a road on which somebody was stopped; on a straight road of two lanes."""

import numpy as np
import pytest

from gpsec.hdmap.map import load_map
from gpsec.outcomes.standing import MOST_SAMPLES, StandingRoads

from .test_moments import moment

PERIOD_S = 0.2
NODES = 'id="a" x="0" y="0"\nid="b" x="300" y="0"'
EDGES = 'id="ab" from="a" to="b" numLanes="2" speed="14"\nid="ba" from="b" to="a" speed="14"'


@pytest.fixture(scope="module")
def road(plain_net):
    return load_map(plain_net(NODES, EDGES), (1.0,))


def east(time_s, road, x_m, speed_mps, *, stopped=(), y_m=None, turn=1.0):
    """Vehicles of the fleet on the right lane of ab, which lies at -4.8 m, towards `turn` times east."""
    n = len(x_m)
    return moment(
        time_s,
        range(n),
        x_m,
        y_m=np.full(n, -4.8) if y_m is None else np.array(y_m),
        ux=np.full(n, turn),
        uy=np.zeros(n),
        speed_mps=np.array(speed_mps, np.float64),
        fleet=np.ones(n, np.bool_),
        lane=np.full(n, road.lane_index["ab_0"], np.int32),
        stopped=np.array([at in stopped for at in range(n)]),
    )


def driven(road, seconds, of, period_s=PERIOD_S):
    roads, before = StandingRoads(road, period_s), []
    for step in range(round(seconds / period_s)):
        now = of(step * period_s)
        roads.see(now, before)
        before.append(now)
    return roads


def test_standing_time_is_counted_by_road(road):
    """One of two stands for 10 s, without having been stopped: no road is watched."""
    roads = driven(road, 10.0, lambda time_s: east(time_s, road, [100.0, 50.0 + time_s], [0.0, 1.0]))
    assert list(roads.standing) == [{"road": "ab", "standing_s": pytest.approx(10.0)}]
    assert list(roads.jam) == []


def test_a_road_is_told_from_before_somebody_stood_there(road):
    """The first vehicle drives at 10 m/s to 100 m, and is a wreck from 10 s on; the second follows 50 m behind."""

    def at(time_s):
        first, second = min(10.0 * time_s, 100.0), min(max(10.0 * time_s - 50.0, 0.0), 95.0)
        speeds = [10.0 if first < 100.0 else 0.0, 0.0 if second in (0.0, 95.0) else 10.0]
        return east(time_s, road, [first, second], speeds, stopped=(0,) if first == 100.0 else ())

    rows = list(driven(road, 30.0, at).jam)
    assert {row["road"] for row in rows} == {"ab"}
    assert rows[0]["length_m"] == pytest.approx(300.0, abs=0.5)
    first = [row for row in rows if row["vehicle"] == 0]
    assert first[0]["time_s"] == 0.0
    assert [row["position_m"] for row in first[:4]] == pytest.approx([0.0, 10.0, 20.0, 30.0])
    assert {row["stopped"] for row in first if row["time_s"] > 10.0} == {True}
    second = [row for row in rows if row["vehicle"] == 1]
    assert second[-1]["position_m"] == pytest.approx(95.0)
    assert second[-1]["speed_mps"] == 0.0
    assert not second[-1]["stopped"]


def test_who_comes_the_other_way_or_is_elsewhere_is_not_on_the_road(road):
    wreck = east(0.0, road, [100.0], [0.0], stopped=(0,))
    other = east(0.2, road, [100.0, 120.0, 140.0, 150.0], [0.0, 9.0, 9.0, 9.0], stopped=(0,), y_m=[-4.8, 1.6, -30.0, 2])
    other.ux[1] = -1.0
    roads = StandingRoads(road, PERIOD_S)
    roads.see(wreck, [])
    roads.see(other._replace(time_s=1.0), [wreck])
    seen = [row["vehicle"] for row in roads.jam if row["time_s"] == 1.0]
    assert seen == [0, 3]  # oncoming, off by 25 m; the last one is displaced onto the oncoming lane


def test_samples_thin_out_where_there_would_be_too_many(road):
    """Two hundred vehicles for a minute would be 12,000 samples."""
    x_m = np.linspace(5.0, 290.0, 200)
    roads = driven(road, 60.0, lambda time_s: east(time_s, road, x_m, np.zeros(200), stopped=(0,)), 1.0)
    rows = list(roads.jam)
    assert len(rows) <= MOST_SAMPLES + 200
    times = sorted({row["time_s"] for row in rows})
    assert times[0] == 0.0
    assert times[-1] > 50.0

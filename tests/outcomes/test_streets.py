"""Where things happen: one vehicle over two edges and the junction between, every figure counted by hand."""

import numpy as np
import pytest
from scipy.stats import poisson

from gpsec.hdmap.arrays import LaneSides
from gpsec.outcomes.metrics import poisson_interval
from gpsec.outcomes.street_names import Streets
from gpsec.outcomes.tables import read_table

from .scene import Scene

LANES = ["main_0", "main_1", ":turn_0_0", "side_0"]
NONE = np.zeros(4)
SIDES = LaneSides(np.array([3.0, 3.5, 3.2, 2.8]), np.array([False, False, True, False]), NONE, NONE, NONE, NONE)
# Of the vehicle in each of 9 steps; it is attacked from step 2 on, seen in 4, out of its lane from 6 on.
ROUTE = [0, 0, 1, 1, 2, 2, 3, 3, 1]


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    scene = Scene(capacity=2, sides=SIDES, lane_ids=LANES)
    for step, lane in enumerate(ROUTE):
        scene.vehicles.lane[:] = lane
        scene.vehicles.speed_mps[:] = 10.0 + step
        if step == 2:
            scene.fork(0, 1, 1, step)
        scene.estimate_m[:] = 0.0
        scene.estimate_m[1, 1, 1] = 2.0 * (step >= 6)
        scene.alarm[1, 0] = step >= 4
        scene.isolated[0, 0] = step in {0, 1, 2, 7}
        scene.observe(step, [0, 1] if step >= 2 else [0])
    scene.close(1, "a")
    scene.close(0, "a")
    folder = tmp_path_factory.mktemp("streets")
    scene.outcomes.write(folder, "lane", 1, replicates=5)
    return folder


def rows(table, **chosen):
    for name, value in chosen.items():
        table = table[table[name] == value]
    return table


def test_exposure_counts_entries_and_time(written):
    table = read_table(written, "streets")
    plain = rows(table, defence="never+none", profile="dsd")
    benign = rows(plain, attack="none").set_index("edge")
    # Two stays on main, in steps 0-3 and 8.
    assert benign["entries"].to_dict() == {"main": 2, ":turn_0": 1, "side": 1}
    assert benign["vehicle_seconds"].to_dict() == pytest.approx({"main": 0.5, ":turn_0": 0.2, "side": 0.2})
    # From the beginning of the attack on: the edge it began on counts as come onto.
    attacked = rows(plain, attack="constant_bias").set_index("edge")
    assert attacked["entries"].to_dict() == {"main": 2, ":turn_0": 1, "side": 1}
    assert attacked["vehicle_seconds"].to_dict() == pytest.approx({"main": 0.3, ":turn_0": 0.2, "side": 0.2})


def test_detections_departures_and_time_without_gnss_have_their_edge(written):
    table = read_table(written, "streets")
    (seen,) = rows(table, attack="constant_bias", defence="cusum+ukf").to_dict("records")
    assert (seen["edge"], seen["detections"], seen["departures"]) == (":turn_0", 1, 0)
    plain = rows(table, attack="constant_bias", defence="never+none").set_index("edge")
    assert plain["departures"].to_dict() == {"main": 0, ":turn_0": 0, "side": 1}
    assert plain["departures_per_vehicle_hour"]["side"] == pytest.approx(1 / (0.2 / 3600))
    alone = rows(table, attack="none", defence="cusum+ukf").set_index("edge")
    assert alone["isolated_seconds"].to_dict() == pytest.approx({"main": 0.3, "side": 0.1})


def test_events_say_where(written):
    table = read_table(written, "events")
    (cusum,) = rows(table, defence="cusum+ukf").to_dict("records")
    assert [cusum[f"start_{name}"] for name in ("edge", "lane", "speed_mps", "lane_width_m", "lanes")] == [
        "main",
        "main_1",
        12.0,
        3.5,
        2.0,
    ]
    assert (cusum["start_in_junction"], cusum["detection_in_junction"]) == (False, True)
    assert (cusum["detection_lane"], cusum["detection_speed_mps"]) == (":turn_0_0", 14.0)
    assert np.isnan(cusum["departure_lane"])
    (plain,) = rows(table, defence="never+none").to_dict("records")
    assert (plain["departure_edge"], plain["departure_speed_mps"], plain["departure_lanes"]) == ("side", 16.0, 1.0)


def test_every_outcome_is_a_flag_of_its_own(written):
    """2 m on a lane of 2.8 m with nothing beside it: a line, the lane, and for 1.8 m of vehicle, no more (2.3 m)."""
    (plain,) = rows(read_table(written, "events"), defence="never+none").to_dict("records")
    reached = [plain[f"reached_{name}"] for name in ("line_touched", "out_of_lane", "wrong_way", "off_road")]
    assert reached == [True, True, False, False]
    assert plain["time_to_out_of_lane_s"] == pytest.approx(0.4)
    assert np.isnan(plain["time_to_off_road_s"])


def test_lanes_of_an_edge_are_counted():
    streets = Streets.on(LANES, SIDES)
    assert list(streets.edge_id) == ["main", ":turn_0", "side"]
    assert list(streets.lanes) == [2, 1, 1]


@pytest.mark.parametrize("count", [0, 1, 7])
def test_the_bounds_of_a_poisson_rate_are_exact(count):
    """At the upper bound, so few or fewer have the probability of the tail; at the lower so many or more."""
    low, high = poisson_interval(np.array([count]), np.array([2.0]), 0.95)
    assert poisson.cdf(count, 2.0 * high.value[0]) == pytest.approx(0.025)
    if count:
        assert poisson.sf(count - 1, 2.0 * low.value[0]) == pytest.approx(0.025)
    else:
        assert low.value[0] == 0.0

"""Which lane a camera shows: that under the rear axle, but for its mistakes."""

import numpy as np
import pytest

from gpsec.core.tables import Table
from gpsec.hdmap.locating import locate
from gpsec.hdmap.map import HDMap, compile_map
from gpsec.types.camera import NO_MISTAKES, LaneMistakes
from gpsec.types.vehicles import Vehicles

from .nets import THREE_LANES

# The middle lane of three of 3.2 m, and the line to its left.
MIDDLE_M, LINE_M, STEP_S = -4.8, -3.2, 0.1


@pytest.fixture(scope="module")
def wide(plain_net) -> HDMap:
    return compile_map(plain_net(*THREE_LANES), ())


class Change:
    """A vehicle that changes from the middle to the left lane, 0.1 m a step; SUMO's lane changes at once."""

    def __init__(self, road: HDMap, mistakes: LaneMistakes = NO_MISTAKES, count: int = 1) -> None:
        self.road, self.mistakes = road, mistakes
        self.vehicles = Table(Vehicles, count).now
        self.vehicles.key[:] = np.random.default_rng(3).integers(0, 2**63, count).astype(np.uint64)
        self.vehicles.rear_m[:] = 100.0, MIDDLE_M
        self.step = 0
        self.go("ab_1")

    def go(self, lane: str, left_m: float = 0.0) -> str:
        """Drive a step; return the lane that the camera shows."""
        vehicles = self.vehicles
        vehicles.lane[:] = self.road.lane_index[lane]
        vehicles.rear_m[:] += (1.0, left_m)
        rows = np.arange(len(vehicles.lane), dtype=np.int32)
        locate(rows, self.step, STEP_S, self.road.roads(np.zeros(1, np.int32)), self.mistakes, vehicles)
        self.step += 1
        return self.road.lane_ids[vehicles.camera_lane[0]]

    def across_m(self) -> float:
        """Go on to the left until the camera shows the left lane; return how far beyond the line the axle is then."""
        while self.go("ab_2", 0.1) == "ab_1":
            assert self.vehicles.rear_m[0, 1] < 0.0
        return float(self.vehicles.rear_m[0, 1] - LINE_M)


def test_the_camera_shows_the_lane_under_the_rear_axle(wide):
    change = Change(wide)
    assert change.go("ab_2") == "ab_1"
    assert change.vehicles.camera_offset_m[0] == pytest.approx(0.0, abs=1e-6)
    assert change.vehicles.lane_offset_m[0] == pytest.approx(-3.2)
    assert change.across_m() == pytest.approx(0.2, abs=0.051)  # the first step beyond 0.1 m
    assert change.vehicles.camera_offset_m[0] == pytest.approx(change.vehicles.lane_offset_m[0])


def test_a_camera_with_more_hysteresis_keeps_to_its_lane_for_longer(wide):
    assert Change(wide, LaneMistakes(hysteresis_m=0.45)).across_m() == pytest.approx(0.5, abs=0.051)


def test_a_late_camera_shows_the_old_lane_for_a_while(wide):
    late = Change(wide, LaneMistakes(late_s=0.5)).across_m()
    assert late == pytest.approx(Change(wide).across_m() + 0.5, abs=1e-6)


def test_a_camera_is_blind_near_a_line(wide):
    change = Change(wide, LaneMistakes(blind_m=0.6))
    seen = {}
    for _ in range(16):
        change.go("ab_1", 0.1)
        seen[round(float(LINE_M - change.vehicles.rear_m[0, 1]), 2)] = bool(change.vehicles.marked[0])
    assert all(marked == (to_line_m > 0.59) for to_line_m, marked in seen.items())
    assert set(seen.values()) == {True, False}


def test_a_camera_shows_the_lane_beside_as_often_and_as_long_as_it_should(wide):
    """3600 times an hour, each for 0.5 s: it begins in a tenth of the steps of 0.1 s in which it does not last."""
    change = Change(wide, LaneMistakes(wrong_per_h=3600.0, wrong_s=0.5), count=200)
    shown = []
    for _ in range(200):
        change.go("ab_1")
        shown.append(change.vehicles.camera_lane.copy())
        wrong = change.vehicles.camera_lane != wide.lane_index["ab_1"]
        assert np.abs(change.vehicles.camera_offset_m[wrong]) == pytest.approx(3.2, abs=1e-6)
        assert np.abs(change.vehicles.camera_offset_m[~wrong]) == pytest.approx(0.0, abs=1e-6)
    lanes = np.array(shown)
    begins = 1.0 - np.exp(-0.1)
    expected = 5.0 * begins / (1.0 - begins + 5.0 * begins)
    assert (lanes != wide.lane_index["ab_1"]).mean() == pytest.approx(expected, abs=0.02)
    left, right = ((lanes == wide.lane_index[name]).mean() for name in ("ab_2", "ab_0"))
    assert left == pytest.approx(right, abs=0.02)


def test_a_mistake_where_there_is_no_lane_shows_its_own(wide):
    change = Change(wide, LaneMistakes(wrong_per_h=3600.0), count=50)
    change.vehicles.rear_m[:, 1] = -8.0
    for _ in range(50):
        change.go("ab_0")
        names = {wide.lane_ids[lane] for lane in change.vehicles.camera_lane}
        assert names <= {"ab_0", "ab_1"}

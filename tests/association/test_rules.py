"""The rules of the association, one at a time, on a road of three lanes that forks behind a junction."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gpsec.association.evidence import CROSSED_M
from gpsec.association.state import Association
from gpsec.association.tracked import BLIND_S, STRIKES, TRUSTED, associate
from gpsec.core.tables import Table
from gpsec.filters.noise import noise_of, noise_table
from gpsec.hdmap.map import HDMap, load_map
from gpsec.reference.association import TrackAssociation
from gpsec.reference.lane_line import LaneLines
from gpsec.reference.perception import sight_of
from gpsec.testing.rig import RIG_FIGURES
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

STEP_S, SPEED_MPS, WIDTH_M = 0.1, 10.0, 3.2


@pytest.fixture(scope="module")
def road(plain_net) -> HDMap:
    """Three lanes east for 600 m; then three go on east, two go north."""
    nodes = 'id="a" x="0" y="0"\nid="b" x="600" y="0"\nid="c" x="900" y="0"\nid="d" x="600" y="300"'
    edges = 'id="ab" from="a" to="b" numLanes="3"\nid="bc" from="b" to="c" numLanes="3"'
    return load_map(plain_net(nodes, edges + '\nid="bd" from="b" to="d" numLanes="2"'), ())


@dataclass
class Car:
    """One vehicle that drives east on the lane `index` (0 is the right one) and keeps a place across it."""

    road: HDMap
    index: int = 1
    x_m: float = 50.0
    offset_m: float = 0.0
    state: Table[Association] = field(default_factory=lambda: Table(Association))

    def __post_init__(self) -> None:
        self.vehicles, self.seen = Table(Vehicles).now, Table(Measurements).now
        self.tracks = Table(Tracks).now
        self.tracks.vehicle[0] = 0
        self.seen.camera_sigma_m[0] = 0.08
        self.noise = noise_table([RIG_FIGURES])
        hd_map = self.road
        self.roads = hd_map.roads(np.zeros(1, np.int32))
        self.centre_m = float(hd_map.centre_line(self.lane)[0, 1])

    @property
    def lane(self) -> int:
        return self.road.lane_index[f"ab_{self.index}"]

    @property
    def now(self) -> Association:
        return self.state.now

    def step(
        self, bias_m=(0.0, 0.0), fix: bool = True, camera: float | None = 0.0, slope: float = 0.0, across_m: float = 0.0
    ) -> None:
        """Drive a step and move by `across_m`.

        The fix is displaced by `bias_m`, and the camera's offset by `camera` (None: it is blind).
        """
        self.x_m += SPEED_MPS * STEP_S
        yaw = np.arctan2(across_m, SPEED_MPS * STEP_S)
        self.seen.speed_mps[0], self.seen.heading_rad[0] = np.hypot(SPEED_MPS, across_m / STEP_S), yaw
        self.tracks.fix_m[0] = self.x_m + bias_m[0], self.centre_m + self.offset_m + bias_m[1]
        self.tracks.fix_valid[0] = fix
        self.seen.camera_valid[0] = camera is not None
        self.seen.lane_poly[0, 0] = -(self.offset_m + (camera or 0.0)) / np.cos(yaw)
        self.seen.lane_poly[0, 1] = slope - np.tan(yaw)
        self._associate()

    def _associate(self) -> None:
        rows = np.zeros(1, np.int32)
        associate(rows, STEP_S, self.roads, self.noise, self.tracks, self.vehicles, self.seen, self.now)

    def drive(self, steps: int, **given) -> None:
        for _ in range(steps):
            self.step(**given)

    def change_lane(self, steps: int = 30) -> None:
        """Move one lane to the left; the camera follows the lane that the vehicle is on."""
        for k in range(steps):
            across = WIDTH_M * (k + 1) / steps
            if across > 0.5 * WIDTH_M and self.offset_m >= 0.0:
                self.index += 1
                self.centre_m += WIDTH_M
            self.offset_m = across - (WIDTH_M if across > 0.5 * WIDTH_M else 0.0)
            self.step(across_m=WIDTH_M / steps)
        self.offset_m = 0.0


class Both(Car):
    """The same vehicle, whose association by hand is held to that of the kernel."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self.own = TrackAssociation(LaneLines(self.road, 0), noise_of(self.noise, 0), STEP_S)

    def _associate(self) -> None:
        super()._associate()
        self.own.step(sight_of(0, 0, self.tracks, self.seen))
        found = (self.tracks.lane[0], self.tracks.lane_known[0], self.tracks.unmatched[0])
        assert found == (self.own.best, self.own.known, self.own.unmatched)
        weights = {int(self.now.lane[0, h]): self.now.weight[0, h] for h in range(self.now.used[0])}
        assert weights == pytest.approx({lane: one.weight for lane, one in self.own.hypotheses.items()})


def test_nothing_is_believed_before_the_first_fix(road: HDMap) -> None:
    car = Car(road)
    car.drive(3, fix=False)
    assert car.tracks.lane[0] == -1
    assert not car.tracks.lane_known[0]
    car.step()
    assert car.tracks.lane[0] == car.lane


@pytest.mark.parametrize("index", [0, 1, 2])
def test_the_lane_of_the_first_fix_is_believed(road: HDMap, index: int) -> None:
    car = Car(road, index)
    car.drive(5)
    assert (car.tracks.lane[0], car.tracks.lane_known[0]) == (car.lane, True)


@pytest.mark.parametrize("index", [0, 1])
def test_a_lane_change_is_seen_in_the_step_in_which_the_camera_changes(road: HDMap, index: int) -> None:
    car = Car(road, index)
    car.drive(40)
    car.change_lane()
    assert car.tracks.lane[0] == car.lane == road.lane_index[f"ab_{index + 1}"]


def test_a_camera_that_is_blind_at_the_line_is_no_obstacle(road: HDMap) -> None:
    car = Car(road, 0)
    car.drive(40)
    before = car.tracks.lane[0]
    for k in range(30):
        car.offset_m = WIDTH_M * (k + 1) / 30
        car.step(camera=None) if 0.3 < car.offset_m / WIDTH_M < 0.7 else car.step(across_m=WIDTH_M / 30)
    car.index, car.centre_m, car.offset_m = 1, car.centre_m + WIDTH_M, 0.0
    car.drive(5)
    assert before != car.tracks.lane[0] == car.lane


@pytest.mark.parametrize("to_left", [True, False])
def test_a_line_that_is_crossed_while_the_camera_is_blind_is_no_surprise(road: HDMap, to_left: bool) -> None:
    side = 1 if to_left else -1
    car = Both(road, 1)
    car.drive(60)
    spoofed = {"bias_m": (0.0, -2.0 * side)}  # as if it had stayed on its lane
    car.drive(20, **spoofed)
    for _ in range(21):
        car.offset_m += 0.08 * side
        car.step(camera=None if abs(car.offset_m) > 1.0 else 0.0, across_m=0.08 * side, **spoofed)
    assert car.now.blind_s[0] > BLIND_S
    assert 0.0 < abs(car.offset_m) - 0.5 * WIDTH_M < CROSSED_M
    car.index, car.centre_m, car.offset_m = 1 + side, car.centre_m + side * WIDTH_M, car.offset_m - side * WIDTH_M
    car.step(**spoofed)
    assert car.now.settling[0] == 0
    car.drive(60, **spoofed)
    assert (car.tracks.lane[0], car.tracks.lane_known[0]) == (car.lane, True)


def test_a_lane_that_is_elsewhere_after_a_blind_stretch_lets_trusted_fixes_decide(road: HDMap) -> None:
    car = Both(road, 1)
    car.drive(60)
    car.drive(10, camera=None)
    doubt = car.now.free_covariance[0, 0]
    car.step(camera=-1.2)
    assert car.now.settling[0] > 0
    assert car.now.free_covariance[0, 0] > doubt + 1.0
    assert not car.tracks.lane_known[0]
    car.drive(60)
    assert (car.tracks.lane[0], car.tracks.lane_known[0]) == (car.lane, True)


@settings(max_examples=40, deadline=None)
@given(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.integers(0, 2))
def test_fixes_that_are_moved_after_the_start_move_no_lane(road: HDMap, east: float, north: float, index: int) -> None:
    car = Car(road, index)
    car.drive(60)
    car.drive(150, bias_m=(east, north))
    assert car.tracks.lane[0] == car.lane


def test_a_slow_displacement_across_moves_no_lane(road: HDMap) -> None:
    car = Car(road)
    car.drive(40)
    for k in range(250):
        car.step(bias_m=(0.0, 0.02 * k))
    assert car.tracks.lane[0] == car.lane


def test_fixes_are_refused_that_jump_and_trusted_again_when_they_come_back(road: HDMap) -> None:
    car = Car(road)
    car.drive(60)
    assert car.now.accepted[0] >= TRUSTED
    car.drive(20, bias_m=(0.0, 2.4))
    assert car.now.accepted[0] == -1
    car.drive(TRUSTED)
    assert car.now.accepted[0] == TRUSTED


def test_the_noise_of_fixes_is_learnt(road: HDMap) -> None:
    rng = np.random.default_rng(1)
    car = Car(road)
    for _ in range(500):
        car.step(bias_m=tuple(rng.normal(scale=0.5, size=2)))
    assert 3.0 < np.exp(0.5 * car.now.noise[0]) < 7.0  # five times the data sheet's 0.1 m
    assert car.tracks.lane[0] == car.lane


def test_a_lane_that_no_hypothesis_explains_is_said_and_begun_anew(road: HDMap) -> None:
    car = Car(road, 0)
    car.drive(60)
    car.step(camera=-1.5)  # beyond the right edge: there is no neighbour
    assert car.tracks.unmatched[0]
    assert car.now.strikes[0] == 1
    car.drive(STRIKES - 1, camera=-1.5)
    assert car.now.strikes[0] == 0
    car.drive(30)
    assert car.tracks.lane[0] == car.lane


def test_two_lanes_as_likely_are_not_known(road: HDMap) -> None:
    car = Car(road)
    car.tracks.fix_m[0] = 0.0, 0.0
    car.centre_m += 0.5 * WIDTH_M  # the fix lies on the line, and the camera sees nothing
    car.step(camera=None)
    assert not car.tracks.lane_known[0]


def test_behind_a_fork_the_lane_that_was_taken_is_believed(road: HDMap) -> None:
    car = Car(road, 1, x_m=500.0)
    while car.x_m < 700.0:
        blind = 585.0 < car.x_m < 620.0
        car.step(camera=None if blind else 0.0)
    assert road.lane_ids[car.tracks.lane[0]] == "bc_1"


def test_a_row_that_is_copied_goes_on_as_the_first(road: HDMap) -> None:
    car = Car(road)
    car.drive(30)
    car.state.grow(2)
    car.state.copy(np.zeros(1, np.int32), np.ones(1, np.int32))
    for array in car.now:
        np.testing.assert_array_equal(array[0], array[1])

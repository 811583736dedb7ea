"""Whether the believed lane is the right one, counted by hand on a road of three lanes."""

import numpy as np
import pytest

from gpsec.core.tables import Table
from gpsec.hdmap.locating import locate
from gpsec.hdmap.map import HDMap, compile_map
from gpsec.outcomes.lanes import PHASES, Judge, association_table, forked_lanes, judge_lanes, no_counts
from gpsec.outcomes.state import OutcomeState
from gpsec.outcomes.study import Study
from gpsec.types.camera import NO_MISTAKES
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles
from tests.hdmap.nets import BEND, THREE_LANES

STUDY = Study(("none", "drift"), (), (), (), (), ("carla",), np.zeros((1, 0)), 0.1)
MIDDLE_M = -4.8


@pytest.fixture(scope="module")
def wide(plain_net) -> HDMap:
    return compile_map(plain_net(*THREE_LANES), ())


class Watched:
    """One vehicle on three lanes with a track under each plan."""

    def __init__(self, road: HDMap) -> None:
        self.road, self.roads = road, road.roads(np.zeros(1, np.int32))
        self.judge = Judge.on(self.roads, 0.1)
        self.vehicles, self.seen = Table(Vehicles).now, Table(Measurements).now
        self.tracks = Table(Tracks, 2).now
        self.tracks.vehicle[:], self.tracks.plan[:], self.tracks.settled[:] = 0, [0, 1], True
        self.tracks.lane_known[:] = True
        self.sums = Table(OutcomeState, 2, detectors=0, defences=0).now
        self.counts = no_counts(2, 1)
        self.vehicles.rear_m[0] = 100.0, MIDDLE_M
        self.seen.camera_valid[0] = True

    def go(self, true: str, believed: str, left_m: float = 0.0) -> None:
        self.vehicles.lane[:] = self.road.lane_index[true]
        self.vehicles.rear_m[0] += (1.0, left_m)
        locate(np.zeros(1, np.int32), 0, 0.1, self.roads, NO_MISTAKES, self.vehicles)
        self.tracks.lane[:] = self.road.lane_index[believed]
        rows = np.arange(2, dtype=np.int32)
        judge_lanes(rows, self.judge, self.tracks, self.vehicles, self.seen, self.sums, self.counts)

    def row(self, attack: str = "none", phase: str = "honest"):
        table = association_table(STUDY, self.counts, "lane")
        return table[(table["attack"] == attack) & (table["phase"] == phase)].iloc[0]


def test_shares_of_right_and_unknown_steps(wide):
    watched = Watched(wide)
    for _ in range(6):
        watched.go("ab_1", "ab_1")
    for _ in range(2):
        watched.go("ab_1", "ab_2")
    watched.tracks.lane_known[:], watched.tracks.unmatched[:], watched.seen.camera_valid[:] = False, True, False
    for _ in range(2):
        watched.go("ab_1", "ab_1")
    row = watched.row()
    assert (row["steps"], row["road_steps"], row["seen_steps"], row["junction_steps"]) == (10, 10, 8, 0)
    assert (row["road_right_share"], row["seen_right_share"]) == (0.8, 0.75)
    assert (row["unknown_share"], row["unmatched_share"]) == (0.2, 0.2)
    assert np.isnan(row["junction_right_share"])
    assert np.isnan(row["right_within_100_ms_share"])
    assert row["association"] == "tracked"


def test_phases_are_counted_apart_and_nothing_before_a_vehicle_has_settled(wide):
    watched = Watched(wide)
    watched.tracks.settled[:] = False
    watched.go("ab_1", "ab_2")
    watched.tracks.attacked[1] = True
    watched.go("ab_1", "ab_1")
    watched.tracks.attacked[1], watched.tracks.settled[:] = False, True
    watched.go("ab_1", "ab_2")
    table = association_table(STUDY, watched.counts, "lane")
    assert table["phase"].tolist() == [PHASES[0], PHASES[1], PHASES[2]]
    assert table["steps"].tolist() == [1, 1, 1]
    assert table["road_right_share"].tolist() == [0.0, 1.0, 0.0]


@pytest.mark.parametrize(
    ("late", "soon_share", "later_share"), [(0, 1.0, 1.0), (1, 1.0, 1.0), (3, 0.0, 1.0), (8, 0.0, 0.0)]
)
def test_lane_changes_are_right_soon_or_later(wide, late, soon_share, later_share):
    """The track sees the change so many steps after the camera."""
    watched = Watched(wide)
    watched.go("ab_1", "ab_1")
    while wide.lane_ids[watched.vehicles.camera_lane[0]] == "ab_1":
        watched.go("ab_2", "ab_1" if late else "ab_2", 0.2)
    for step in range(1, 12):
        watched.go("ab_2", "ab_1" if step < late else "ab_2", 0.0)
    row = watched.row()
    assert row["lane_changes"] == 1
    assert (row["right_within_100_ms_share"], row["right_within_500_ms_share"]) == (soon_share, later_share)


def test_steps_on_a_lane_that_leads_the_other_way_are_left_out(wide):
    watched = Watched(wide)
    watched.vehicles.yaw_rad[0] = np.pi
    watched.go("ab_1", "ab_1")
    assert watched.counts.sum() == 0


def test_lanes_behind_a_fork(plain_net):
    bend = compile_map(plain_net(*BEND), ())
    forked = forked_lanes(bend.roads(np.zeros(1, np.int32)))
    assert {lane for lane, is_one in zip(bend.lane_ids, forked, strict=True) if is_one} == {
        lane for lane in bend.lane_ids if lane.startswith(":b")
    }

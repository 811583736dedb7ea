"""What the association stands that vehicles do not know of: noise, and a camera that is blind or mistaken."""

from dataclasses import dataclass
from functools import cache
from math import sqrt

import numpy as np
import pytest

from gpsec.core.tables import Table
from gpsec.outcomes.lanes import Judge, association_table, judge_lanes, no_counts
from gpsec.outcomes.state import OutcomeState
from gpsec.outcomes.study import Study
from gpsec.pipeline.loop import Loop
from gpsec.pipeline.loop_settings import LoopSettings
from gpsec.sensors.mismatch import AS_STATED, Mismatch
from gpsec.sensors.registry import PROFILES
from gpsec.sensors.sense import Sensors
from gpsec.traffic.recording import RecordedTraffic
from gpsec.types.answers import Answers
from gpsec.types.camera import NO_MISTAKES, LaneMistakes
from tests.parity.drive import Drive, record_drive

STUDY = Study(("none",), (), (), (), (), ("carla",), np.zeros((1, 0)), 0.1)
_GNSS = PROFILES["carla"].gnss.white_m
# Blind for 3 s every 11.5 s.
_BLIND = {"outages_per_h": 3600.0 / 8.5, "outage_mean_s": 3.0}


class Judged:
    """Implements `gpsec.types.method.Method`: the association of every track, judged, and nothing else."""

    def __init__(self, drive: Drive) -> None:
        self.association = drive.ground.association
        self.lanes = self.association.new_state(1)
        self.judge = Judge.on(drive.ground.hd_map.roads(np.zeros(1, np.int32)), 0.1)
        self.sums = Table(OutcomeState, detectors=0, defences=0)
        self.counts = no_counts(1, 1)
        self._answers = Table(Answers, 1, detectors=0, defences=1)

    @property
    def answers(self) -> Answers:
        return self._answers.now

    def _states(self):
        return self._answers, self.lanes, self.sums

    def grow(self, capacity):
        for state in self._states():
            state.grow(capacity)

    def reset(self, rows):
        for state in self._states():
            state.reset(rows)

    def step(self, number, rows, tracks, vehicles, seen, threads, watch):
        self.association.update(self.lanes.now, rows, tracks, vehicles, seen, threads)
        judge_lanes(rows, self.judge, tracks, vehicles, seen, self.sums.now, self.counts)


@dataclass(frozen=True)
class Stress:
    """What vehicles do not know of, and the goals: right on roads, and within half a second of a lane change."""

    road: float
    later: float = 0.99
    sensors: Mismatch = AS_STATED
    camera: LaneMistakes = NO_MISTAKES
    blind: bool = False


STRESS = {
    "nothing": Stress(0.999),
    "GNSS noise + 0.5 m": Stress(0.995, sensors=Mismatch(gnss_white=sqrt(_GNSS**2 + 0.25) / _GNSS)),
    "GNSS noise and bias x 2": Stress(0.995, sensors=Mismatch(gnss_white=2.0, gnss_slow=2.0)),
    "camera noise x 2.5": Stress(0.999, sensors=Mismatch(camera=2.5)),
    "camera blind at the line": Stress(0.99, later=0.95, camera=LaneMistakes(blind_m=0.6)),
    "camera keeps the old lane": Stress(0.999, camera=LaneMistakes(hysteresis_m=0.4)),
    "camera drops out": Stress(0.997, later=0.9, blind=True),
    "camera shows a wrong lane 60 times an hour": Stress(0.999, later=0.95, camera=LaneMistakes(wrong_per_h=60.0)),
}


@cache
def recorded(name: str, duration_s: float) -> Drive:
    return record_drive(name, duration_s, profiles=("carla",))


def judged(drive: Drive, stress: Stress):
    """The row of the table of honest vehicles of a drive under stress."""
    profile = PROFILES["carla"]
    if stress.blind:
        profile = profile.model_copy(update={"camera": profile.camera.model_copy(update=_BLIND)})
    settings = LoopSettings(
        seed=5,
        step_s=0.1,
        origin_s=drive.ground.options.begin_s,
        settle_s=3.0,
        hd_map=drive.ground.hd_map,
        sensors=Sensors((profile,), 0.1, stress.sensors),
        profile_of=lambda departure: 0,
        mistakes=stress.camera,
    )
    method = Judged(drive)
    loop = Loop(settings, (), method)
    for frame in RecordedTraffic(drive.recording).frames(None):
        loop.step(frame)
    return association_table(STUDY, method.counts, "stress").iloc[0]


@pytest.mark.parametrize("stress", STRESS.values(), ids=STRESS)
def test_the_lane_stays_right_under_stress(stress: Stress) -> None:
    row = judged(recorded("highway", 60.0), stress)
    assert row["road_steps"] > 15000
    assert row["lane_changes"] > 20
    assert row["road_right_share"] >= stress.road
    assert row["right_within_500_ms_share"] >= stress.later
    assert row["unknown_share"] < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("name", ["town", "highway"])
@pytest.mark.parametrize("stress", STRESS.values(), ids=STRESS)
def test_the_lane_stays_right_under_stress_for_longer(name: str, stress: Stress) -> None:
    row = judged(recorded(name, 120.0), stress)
    assert row["road_right_share"] >= stress.road
    assert row["right_within_500_ms_share"] >= stress.later


def test_who_is_told_is_always_right_even_of_a_wrong_lane() -> None:
    told = recorded("highway", 60.0).associated("oracle")
    row = judged(told, STRESS["camera shows a wrong lane 60 times an hour"])
    assert (row["road_right_share"], row["unknown_share"]) == (1.0, 0.0)

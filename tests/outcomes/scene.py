"""A handful of tracks that a test moves by hand."""

from __future__ import annotations

import numpy as np

from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.hdmap.arrays import LaneSides
from gpsec.outcomes.kept_traces import KeptTraces
from gpsec.outcomes.recorder import Outcomes
from gpsec.outcomes.study import Study
from gpsec.outcomes.view import StepView
from gpsec.testing.rig import straight_road
from gpsec.types.answers import Answers
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Identity, Measurements, Vehicles

PLANS = ("none", "constant_bias")
DETECTORS = ("cusum", "never")
DEFENCES = (("cusum", "ukf"), ("never", "none"))
PROFILES = ("dsd", "carla")


def lane_sides(
    width=3.5, *, internal=False, same_left=0.0, same_right=0.0, oncoming_left=0.0, oncoming_right=0.0
) -> LaneSides:
    """One lane."""
    return LaneSides(
        np.array([width]),
        np.array([internal]),
        np.array([same_left]),
        np.array([same_right]),
        np.array([oncoming_left]),
        np.array([oncoming_right]),
    )


class Scene:
    """M vehicles on one lane towards east, each with a track (row = vehicle row) under plan 0."""

    def __init__(self, capacity=4, sides=None, step_s=0.1, lane_ids=("e_0",), *, traced=False, **names):
        names = {
            "plan_names": PLANS,
            "detector_names": DETECTORS,
            "defences": DEFENCES,
            "profile_names": PROFILES,
        } | names
        k, d = len(names["detector_names"]), len(names["defences"])
        thresholds = np.arange(len(names["profile_names"]) * k, dtype=float).reshape(-1, k) + 1.0
        study = Study(
            names["plan_names"],
            names["detector_names"],
            tuple("" if name in ("never", "told") else "0.1/h" for name in names["detector_names"]),
            tuple("fixed" if name in ("never", "told") else "counted" for name in names["detector_names"]),
            names["defences"],
            names["profile_names"],
            thresholds,
            step_s,
        )
        roads = straight_road().roads(np.zeros(1, np.int32))
        traces = KeptTraces(study) if traced else None
        self.outcomes = Outcomes(study, roads._replace(sides=sides or lane_sides()), lane_ids, traces)
        self.outcomes.table.grow(capacity)
        self.step_s = step_s
        self._tracks = Table(Tracks, capacity)
        self.vehicles = Table(Vehicles, capacity).now
        self.vehicles.lane[:] = self.vehicles.camera_lane[:] = 0
        self.seen = Table(Measurements, capacity).now
        self.tracks.vehicle[:] = np.arange(capacity)
        self.tracks.settled[:] = True
        self.answers = Table(Answers, capacity, detectors=k, defences=d).now
        self.statistic, self.scored, self.alarm = self.answers.statistic, self.answers.scored, self.answers.alarm
        self.estimate_m, self.isolated = self.answers.estimate_m, self.answers.isolated
        self.scored[:] = True

    @property
    def tracks(self) -> Tracks:
        return self._tracks.now

    @property
    def state(self):
        return self.outcomes.state

    def view(self, step, rows) -> StepView:
        return StepView(
            step=step,
            step_s=self.step_s,
            time_s=(step + 1) * self.step_s,
            rows=np.asarray(rows, np.int32),
            tracks=self.tracks,
            vehicles=self.vehicles,
            seen=self.seen,
            answers=self.answers,
        )

    def observe(self, step, rows, threads=None):
        self.outcomes.observe(self.view(step, rows), threads or Threads())

    def fork(self, source, target, plan, step):
        """Begin an attack: a track of the vehicle of `source` under `plan`, in the row `target`."""
        pair = np.array([source]), np.array([target])
        self._tracks.copy(*pair)
        for table in self.outcomes.tables():
            table.copy(*pair)
        self.tracks.plan[target] = plan
        self.tracks.attacked[target] = True
        self.tracks.start_step[target] = step

    def end_attack(self, row, step):
        self.tracks.attacked[row] = False
        self.tracks.end_step[row] = step

    def close(self, row, vehicle_id, *, profile=0, depart_s=0.0, arrive_s=None):
        who = Identity(vehicle_id, "car", profile, depart_s, vehicle_id)
        self.outcomes.close(np.array([row], np.int32), self.tracks, [who], arrive_s)

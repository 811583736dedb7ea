"""A handful of tracks that a test moves by hand."""

from __future__ import annotations

import numpy as np

from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.hdmap.arrays import LaneSides
from gpsec.outcomes.events import Journey
from gpsec.outcomes.recorder import Outcomes
from gpsec.outcomes.view import StepView
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

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

    def __init__(self, capacity=4, sides=None, step_s=0.1, **names):
        names = {
            "plan_names": PLANS,
            "detector_names": DETECTORS,
            "defences": DEFENCES,
            "profile_names": PROFILES,
        } | names
        k, d = len(names["detector_names"]), len(names["defences"])
        self.outcomes = Outcomes(
            **names,
            thresholds=np.arange(len(names["profile_names"]) * k, dtype=float).reshape(-1, k) + 1.0,
            lane_sides=sides or lane_sides(),
            step_s=step_s,
            capacity=capacity,
        )
        self.step_s = step_s
        self._tracks = Table(Tracks, capacity)
        self.vehicles = Table(Vehicles, capacity).now
        self.vehicles.lane[:] = 0
        self.seen = Table(Measurements, capacity).now
        self.tracks.vehicle[:] = np.arange(capacity)
        self.tracks.settled[:] = True
        self.statistic = np.zeros((capacity, k))
        self.scored = np.ones((capacity, k), np.bool_)
        self.alarm = np.zeros((capacity, k), np.bool_)
        self.estimate_m = np.zeros((capacity, d, 2))
        self.isolated = np.zeros((capacity, d), np.bool_)

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
            statistic=self.statistic,
            scored=self.scored,
            alarm=self.alarm,
            estimate_m=self.estimate_m,
            isolated=self.isolated,
        )

    def observe(self, step, rows, threads=None):
        self.outcomes.observe(self.view(step, rows), threads or Threads())

    def fork(self, source, target, plan, step):
        """Begin an attack: a track of the vehicle of `source` under `plan`, in the row `target`."""
        pair = np.array([source]), np.array([target])
        self._tracks.copy(*pair)
        self.state.copy(*pair)
        self.tracks.plan[target] = plan
        self.tracks.attacked[target] = True
        self.tracks.start_step[target] = step

    def end_attack(self, row, step):
        self.tracks.attacked[row] = False
        self.tracks.end_step[row] = step

    def close(self, row, vehicle_id, *, profile=0, depart_s=0.0, arrive_s=None):
        journey = Journey(vehicle_id, "car", profile, depart_s, arrive_s)
        self.outcomes.close(np.array([row], np.int32), self.tracks, [journey])

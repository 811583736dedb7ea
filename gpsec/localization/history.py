"""What a response needs that goes back in time: odometry and camera of each vehicle, and what the filters were.

Odometry and camera are kept for every step, once for a vehicle, whatever the number of its plans and defences. What a
filter was is kept at a few steps only, so that memory does not grow with the time that is gone back.
"""

from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.core.tables import Table, blank
from gpsec.localization.state import Branches
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# How many times in the past each filter keeps.
SNAPSHOTS = 5


class Recall(NamedTuple):
    """How far back to go.

    Attributes:
        reach: steps that are gone back at least, where the track is that old.
        interval: steps from one kept filter to the next; back from any step, one of `SNAPSHOTS` is `reach` old.
        step_s: length of a step.

    """

    reach: int
    interval: int
    step_s: float

    @classmethod
    def over(cls, rollback_s: float, step_s: float) -> "Recall":
        """Return how to keep at least `rollback_s`."""
        reach = int(np.ceil(rollback_s / step_s - 1e-6))
        return cls(reach, max(-(-reach // (SNAPSHOTS - 1)), 1), step_s)

    @property
    def steps(self) -> int:
        """Number of steps whose odometry is needed."""
        return SNAPSHOTS * self.interval


class History(NamedTuple):
    """The last L steps of N vehicle rows.

    Attributes:
        recorded: (N,) steps recorded so far; step i is at i % L.
        due: (N,) this step is not yet recorded.
        motion: (N, L, 3) speed (m/s), yaw rate (rad/s) and heading (rad) as measured.
        camera: (N, L, 3) the camera's C0, C1 and the standard deviation (m) that it states for C0.
    """

    recorded: Ints = blank(0)
    due: Flags = blank(False)
    motion: Floats = blank(0.0, "steps", 3)
    camera: Floats = blank(0.0, "steps", 3)


class Beliefs(NamedTuple):
    """The lanes that M track rows believed to be on in the last L steps.

    Attributes:
        lane: (M, L) in the places of `History`, -1 where the camera saw none, or which one it was is not known.
    """

    lane: Ints = blank(-1, "steps")


class Recorded(NamedTuple):
    """All that is recorded.

    Attributes:
        history: of the vehicles.
        lane: (M, L) of `Beliefs`.
    """

    history: History
    lane: Ints


def record_step(
    rows: Ints, history: Table[History], beliefs: Table[Beliefs], tracks: Tracks, vehicles: Vehicles, seen: Measurements
) -> None:
    """Record this step of the track rows `rows`; what the sensors say, once for each vehicle.

    A row that another vehicle takes over needs no reset: no filter is older than its vehicle.
    """
    history.grow(len(vehicles.lane))
    _record(rows, history.now, beliefs.now, tracks, seen)


@kernel
def _record(rows: Ints, history: History, beliefs: Beliefs, tracks: Tracks, seen: Measurements) -> None:
    for row in rows:
        history.due[tracks.vehicle[row]] = True
    for row in rows:
        v = tracks.vehicle[row]
        if not history.due[v]:
            continue  # another track of the vehicle has recorded it
        history.due[v] = False
        slot = history.recorded[v] % history.motion.shape[1]
        history.motion[v, slot, 0] = seen.speed_mps[v]
        history.motion[v, slot, 1] = seen.yaw_rate_rps[v]
        history.motion[v, slot, 2] = seen.heading_rad[v]
        history.camera[v, slot, 0] = seen.lane_poly[v, 0]
        history.camera[v, slot, 1] = seen.lane_poly[v, 1]
        history.camera[v, slot, 2] = seen.camera_sigma_m[v]
        history.recorded[v] += 1
    for row in rows:
        v = tracks.vehicle[row]
        known = seen.camera_valid[v] and tracks.lane_known[row]
        beliefs.lane[row, entry(history, v, 0)] = tracks.lane[row] if known else -1


@inline
def keep_snapshot(branches: Branches, row: int, step: int, interval: int, isolated: bool) -> None:
    """Keep the filter as it is before step `step`, where that is one of those to be kept."""
    if step % interval != 0:
        return
    k = step // interval % branches.past_isolated.shape[1]
    at = 0
    branches.past_isolated[row, k] = isolated
    for i in range(branches.mean.shape[1]):
        branches.past_mean[row, k, i] = branches.mean[row, i]
        for j in range(i + 1):
            branches.past_covariance[row, k, at] = branches.covariance[row, i, j]
            at += 1


@inline
def restore(branches: Branches, row: int, recall: Recall) -> tuple[int, bool]:
    """Make the filter what it was `recall.reach` or more steps before the last, or at its start.

    Returns before which step that was, and whether it was isolated.
    """
    last = branches.steps[row] - 1
    interval = recall.interval
    number = max(last - recall.reach, 0) // interval
    k = number % branches.past_isolated.shape[1]
    at = 0
    for i in range(branches.mean.shape[1]):
        branches.mean[row, i] = branches.past_mean[row, k, i]
        for j in range(i + 1):
            branches.covariance[row, i, j] = branches.past_covariance[row, k, at]
            branches.covariance[row, j, i] = branches.past_covariance[row, k, at]
            at += 1
    branches.segment[row] = -1
    branches.isolated_way_m[row] = 0.0
    return number * interval, branches.past_isolated[row, k]


@inline
def entry(history: History, vehicle: int, ago: int) -> int:
    """Return where in the ring the step is that was `ago` steps before the last."""
    return int((history.recorded[vehicle] - 1 - ago) % history.motion.shape[1])

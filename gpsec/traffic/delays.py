"""What the fleet loses against free driving, and who stands for no reason; looked at once a second."""

import libsumo
import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.traffic.actuation import Actuation
from gpsec.traffic.source import Frame

_EVERY_S, _STANDING_MPS, _STUCK_S = 1.0, 0.1, 30.0
# A leader, a stop line or a junction that is nearer is a reason to stand; one look without a reason is none: who gives
# way may be about to go.
_NEAR_M, _IDLE_LOOKS = 15.0, 5


class Delays:
    """Sums over the fleet.

    Attributes:
        lost_s: seconds lost so far, as SUMO counts them.
        stuck: vehicles so far that stood for half a minute, at the end of it for no reason: without a leader, a light,
            a stop, a brake or somebody to whom they give way.
    """

    def __init__(self, step_s: float) -> None:
        self.lost_s = 0.0
        self.stuck = 0
        self._every = max(1, round(_EVERY_S / step_s))
        self._looks = round(_STUCK_S / (self._every * step_s))  # in which a vehicle that is stuck stands
        self._lost_s: Floats = np.zeros(1)
        self._stood: Ints = np.zeros(1, np.int32)
        self._idle: Ints = np.zeros(1, np.int32)

    def read(self, frame: Frame, actuation: Actuation) -> None:
        """Take in a step."""
        rows = frame.rows
        if len(rows) and rows[-1] >= len(self._lost_s):
            more = 2 * int(rows[-1]) + 2 - len(self._lost_s)
            self._lost_s = np.concatenate([self._lost_s, np.zeros(more)])
            self._stood, self._idle = (
                np.concatenate([looks, np.zeros(more, np.int32)]) for looks in (self._stood, self._idle)
            )
        for departure in frame.departures:
            self._lost_s[departure.row] = self._stood[departure.row] = self._idle[departure.row] = 0
        if frame.step % self._every:
            return
        vehicle = libsumo.vehicle
        names = [actuation.name_of(row) or "" for row in rows.tolist()]
        before = self._lost_s[rows]
        self._lost_s[rows] = list(map(vehicle.getTimeLoss, names))
        self.lost_s += float(np.maximum(self._lost_s[rows] - before, 0.0).sum())
        stands = np.array(list(map(vehicle.getSpeed, names))) < _STANDING_MPS
        self._stood[rows] = np.where(stands, self._stood[rows] + 1, 0)
        self._idle[rows[~stands]] = 0
        for row in rows[self._stood[rows] >= self._looks].tolist():
            name, brakes = actuation.name_of(row) or "", bool(actuation.now.brake_mps2[row] > 0.0)
            self._idle[row] = self._idle[row] + 1 if not brakes and _for_no_reason(name) else 0
            self.stuck += int(self._idle[row] == _IDLE_LOOKS)


def _for_no_reason(name: str) -> bool:
    """Return whether a vehicle that stands has no leader, light or stop before it, and gives way to nobody."""
    vehicle = libsumo.vehicle
    leader = vehicle.getLeader(name, _NEAR_M)
    light = vehicle.getNextTLS(name)[:1]
    waits = any(distance_m < _NEAR_M and state.lower() != "g" for _, _, distance_m, state in light)
    return not (waits or vehicle.isStopped(name) or (leader is not None and leader[0]) or _gives_way(name))


def _gives_way(name: str) -> bool:
    """Return whether somebody who moves has the right of way before a vehicle, which is at the junction."""
    vehicle = libsumo.vehicle
    foes = (foe for foe, *_, must, _ in vehicle.getJunctionFoes(name, _NEAR_M) if must)
    return any(vehicle.getSpeed(foe) >= _STANDING_MPS for foe in foes)

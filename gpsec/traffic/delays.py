"""What the fleet loses against free driving, and who stands for no reason; looked at once a second."""

import libsumo
import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.traffic.actuation import Actuation
from gpsec.traffic.source import Frame

_EVERY_S, _STANDING_MPS, _STUCK_S = 1.0, 0.1, 30.0
# A leader or a stop line that is nearer is a reason to stand.
_NEAR_M = 15.0


class Delays:
    """Sums over the fleet.

    Attributes:
        lost_s: seconds lost so far, as SUMO counts them.
        stuck: vehicles so far that stood for half a minute without a leader, a light, a stop or a brake.
    """

    def __init__(self, step_s: float) -> None:
        self.lost_s = 0.0
        self.stuck = 0
        self._every = max(1, round(_EVERY_S / step_s))
        self._looks = round(_STUCK_S / (self._every * step_s))  # in which a vehicle that is stuck stands
        self._lost_s: Floats = np.zeros(1)
        self._stood: Ints = np.zeros(1, np.int32)

    def read(self, frame: Frame, actuation: Actuation) -> None:
        """Take in a step."""
        rows = frame.rows
        if len(rows) and rows[-1] >= len(self._lost_s):
            more = 2 * int(rows[-1]) + 2 - len(self._lost_s)
            self._lost_s = np.concatenate([self._lost_s, np.zeros(more)])
            self._stood = np.concatenate([self._stood, np.zeros(more, np.int32)])
        for departure in frame.departures:
            self._lost_s[departure.row], self._stood[departure.row] = 0.0, 0
        if frame.step % self._every:
            return
        vehicle = libsumo.vehicle
        names = [actuation.name_of(row) or "" for row in rows.tolist()]
        before = self._lost_s[rows]
        self._lost_s[rows] = list(map(vehicle.getTimeLoss, names))
        self.lost_s += float(np.maximum(self._lost_s[rows] - before, 0.0).sum())
        stands = np.array(list(map(vehicle.getSpeed, names))) < _STANDING_MPS
        self._stood[rows] = np.where(stands, self._stood[rows] + 1, 0)
        for row in rows[self._stood[rows] == self._looks].tolist():
            self.stuck += _for_no_reason(actuation.name_of(row) or "", bool(actuation.now.brake_mps2[row] > 0.0))


def _for_no_reason(name: str, brakes: bool) -> bool:
    """Return whether a vehicle that stands has neither a leader nor a light before it, and neither stops nor brakes."""
    vehicle = libsumo.vehicle
    leader = vehicle.getLeader(name, _NEAR_M)
    light = vehicle.getNextTLS(name)[:1]
    waits = any(distance_m < _NEAR_M and state.lower() != "g" for _, _, distance_m, state in light)
    return not (brakes or waits or vehicle.isStopped(name) or (leader is not None and leader[0]))

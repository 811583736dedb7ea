"""What the fleet loses against free driving, and who stands for no reason; looked at once a second."""

from collections.abc import Callable
from functools import cache

import libsumo
import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.traffic.actuation import Actuation
from gpsec.traffic.source import Frame
from gpsec.traffic.waits import HALTED_MPS, is_stuck

LOSS_EVERY_S, _STUCK_S = 1.0, 30.0
# One look without a reason is none: who gives way may be about to go.
_IDLE_LOOKS = 5


class Delays:
    """Sums over the fleet.

    Attributes:
        lost_s: seconds lost so far, as SUMO counts them.
        stuck: vehicles so far that stood for half a minute, at the end of it for no reason, see
            `gpsec.traffic.waits.is_stuck`.
    """

    def __init__(self, step_s: float) -> None:
        self.lost_s = 0.0
        self.stuck = 0
        self._every = max(1, round(LOSS_EVERY_S / step_s))
        self._looks = round(_STUCK_S / (self._every * step_s))  # in which a vehicle that is stuck stands
        self._lost_s: Floats = np.zeros(1)
        self._stood: Ints = np.zeros(1, np.int32)
        self._idle: Ints = np.zeros(1, np.int32)

    def read(self, frame: Frame, actuation: Actuation, is_held: Callable[[str], bool]) -> None:
        """Take in a step; `is_held` says whether a vehicle is to stand, or somebody who is stands in its way."""
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
        stands = np.array(list(map(vehicle.getSpeed, names))) < HALTED_MPS
        self._stood[rows] = np.where(stands, self._stood[rows] + 1, 0)
        self._idle[rows[~stands]] = 0
        held = cache(is_held)  # who stand in a queue wait for the same ones
        for row in rows[self._stood[rows] >= self._looks].tolist():
            self._idle[row] = self._idle[row] + 1 if is_stuck(actuation.name_of(row) or "", held) else 0
            self.stuck += int(self._idle[row] == _IDLE_LOOKS)

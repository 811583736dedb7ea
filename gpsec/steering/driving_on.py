"""Reactions that drive on: by the estimate, or by the driver."""

from math import exp, log, sqrt
from typing import ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from gpsec.core.arrays import Floats, Ints, Keys
from gpsec.core.kernels import allocating_kernel
from gpsec.core.noise import TAKEOVER_TIME, normal
from gpsec.core.tables import blank
from gpsec.steering.base import Conduct, Follow, Nothing, Reaction, Situation
from gpsec.steering.stopping import lasting


class DriveOn(Reaction):
    """Drive on and steer by the estimate of the defence, which is to hold."""

    name: ClassVar[str] = "continue"

    def react(self, situation: Situation, state: Nothing) -> Conduct:
        """Return that nothing changes."""
        count = len(situation.rows)
        return Conduct(np.full(count, Follow.ESTIMATE, np.int32), np.zeros(count))


class Asked(NamedTuple):
    """What is remembered of a request to take over.

    Attributes:
        alarm_step: (N,) last step in alarm, -1 for none.
        asked_step: (N,) step of the request, -1 for none.
        takes_s: (N,) time that the driver needs.
    """

    alarm_step: Ints = blank(-1)
    asked_step: Ints = blank(-1)
    takes_s: Floats = blank(0.0)


class Handover(Reaction):
    """Ask the driver to take over; until then the estimate steers, and without an answer the vehicle stops in its lane.

    The time is lognormal with the mean and the standard deviation of 520 means of 129 studies (Zhang et al., 2019,
    doi 10.1016/j.trf.2019.04.020): 2.72 and 1.45 s, which leave out drivers who did not react at all. Drivers who were
    not hurried took 1.97 to 25.75 s (median 4.56 s; Eriksson and Stanton, 2017, doi 10.1177/0018720816685832). The
    driver sees the lane. The vehicle drives itself again when the alarm has been over for a while.

    Attributes:
        takeover_mean_s, takeover_sd_s: of the time until the driver steers.
        mrm_after_s: time after the request from which the vehicle brakes by itself, as UN R157 has it.
        mrm_decel_mps2: of that minimal-risk manoeuvre.
        hold_s: time after the alarm after which the vehicle drives itself again.
    """

    name: ClassVar[str] = "handover"
    state: ClassVar[type[NamedTuple]] = Asked
    takeover_mean_s: float = Field(2.7, gt=0.0, le=60.0)
    takeover_sd_s: float = Field(1.45, gt=0.0, le=60.0)
    mrm_after_s: float = Field(10.0, ge=0.0, le=600.0)
    mrm_decel_mps2: float = Field(1.5, gt=0.0, le=9.0)
    hold_s: float = Field(5.0, ge=0.0, le=600.0)

    def react(self, situation: Situation, state: Asked) -> Conduct:
        """Return who steers, and who brakes for want of a driver."""
        rows = situation.rows
        asked = lasting(situation, state.alarm_step, self.hold_s)
        state.asked_step[rows[~asked]] = -1
        new = asked & (state.asked_step[rows] < 0)
        state.asked_step[rows[new]] = situation.step
        spread = sqrt(log(1.0 + (self.takeover_sd_s / self.takeover_mean_s) ** 2))
        middle = log(self.takeover_mean_s) - 0.5 * spread * spread
        state.takes_s[rows[new]] = _lognormals(situation.key[new], situation.step, middle, spread)
        waited_s = (situation.step - state.asked_step[rows]) * situation.step_s
        drives = asked & (waited_s >= state.takes_s[rows])
        stops = asked & ~drives & (waited_s >= self.mrm_after_s)
        follow = np.where(drives | stops, Follow.LANE, Follow.ESTIMATE).astype(np.int32)
        return Conduct(follow, np.where(stops, self.mrm_decel_mps2, 0.0))


@allocating_kernel
def _lognormals(keys: Keys, step: int, middle: float, spread: float) -> Floats:
    """Return a lognormal draw for each of (m,) keys; `middle` and `spread` are those of its logarithm."""
    draws = np.empty(len(keys))
    for i in range(len(keys)):
        draws[i] = exp(middle + spread * normal(keys[i], TAKEOVER_TIME, step))
    return draws

"""Reactions that stop the vehicle: in its lane, or at the edge of the road."""

from typing import ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from gpsec.core.arrays import Flags, Ints
from gpsec.core.tables import blank
from gpsec.steering.base import Conduct, Follow, Reaction, Situation


class LastAlarm(NamedTuple):
    """What is remembered of alarms: alarm_step (N,), the last step in alarm, -1 for none."""

    alarm_step: Ints = blank(-1)


def lasting(situation: Situation, alarm_step: Ints, hold_s: float) -> Flags:
    """Return (m,) whether there is an alarm, or was one within `hold_s`; notes it in (N,) `alarm_step`."""
    rows = situation.rows
    alarm_step[rows[situation.alarm]] = situation.step
    since = (situation.step - alarm_step[rows]) * situation.step_s
    return np.asarray((alarm_step[rows] >= 0) & (since <= hold_s))


class StopInLane(Reaction):
    """Stop in the lane, steered by the camera, until the alarm has been over for a while.

    Attributes:
        decel_mps2: of the braking. 2 m/s² is comfortable, and half of the 4 m/s² that UN R157 allows a minimal-risk
            manoeuvre.
        hold_s: the vehicle drives on so long after the alarm.
    """

    name: ClassVar[str] = "stop"
    state: ClassVar[type[NamedTuple]] = LastAlarm
    decel_mps2: float = Field(2.0, gt=0.0, le=9.0)
    hold_s: float = Field(5.0, ge=0.0, le=600.0)
    _follow: ClassVar[Follow] = Follow.LANE

    def react(self, situation: Situation, state: LastAlarm) -> Conduct:
        """Return the braking of those in alarm."""
        stops = lasting(situation, state.alarm_step, self.hold_s)
        follow = np.where(stops, self._follow, Follow.ESTIMATE).astype(np.int32)
        return Conduct(follow, np.where(stops, self.decel_mps2, 0.0))


class PullOver(StopInLane):
    """Stop at the edge of the road, steered by the camera, until the alarm has been over for a while.

    Attributes:
        decel_mps2: of the braking.
        hold_s: the vehicle drives on so long after the alarm.
    """

    name: ClassVar[str] = "pull_over"
    _follow: ClassVar[Follow] = Follow.EDGE

"""Linger: keep to the lane that the camera shows for a while after an alarm, and slow down."""

from typing import ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from gpsec.core.arrays import Ints
from gpsec.core.tables import blank
from gpsec.steering.base import Conduct, Follow, Reaction, Situation


class Alarmed(NamedTuple):
    """What is remembered of alarms: last_step (N,), the last step in alarm, -1 for none."""

    last_step: Ints = blank(-1)


class Linger(Reaction):
    """Follow the lane from an alarm on until some time after it, and brake while it lasts.

    Attributes:
        linger_s: time for which the lane is followed after the alarm.
        decel_mps2: of the braking.
    """

    name: ClassVar[str] = "linger"
    state: ClassVar[type[NamedTuple]] = Alarmed
    linger_s: float = Field(3.0, ge=0.0, le=60.0)
    decel_mps2: float = Field(1.0, gt=0.0, le=9.0)

    def react(self, situation: Situation, state: Alarmed) -> Conduct:
        """Return the lane for those who had an alarm lately."""
        rows = situation.rows
        state.last_step[rows[situation.alarm]] = situation.step
        since_s = (situation.step - state.last_step[rows]) * situation.step_s
        lane = (state.last_step[rows] >= 0) & (since_s <= self.linger_s)
        follow = np.where(lane, Follow.LANE, Follow.ESTIMATE).astype(np.int32)
        return Conduct(follow, np.where(situation.alarm, self.decel_mps2, 0.0))

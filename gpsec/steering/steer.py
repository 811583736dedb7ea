"""Who is steered by gpsec, since when, and to where: attacks and alarms become wishes to SUMO."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints, Keys
from gpsec.core.tables import Table, blank
from gpsec.steering.base import Conduct, Follow, LateralDynamics, LateralMotion, Reaction, Situation

# After an attack the estimate steers until its error is below this, or for this long; then the vehicle goes back to the
# middle of its lane, and is SUMO's again once it is as near to that as this.
_BELIEVED_M, _BELIEVED_S = 0.5, 30.0
_BACK_M, _BACK_MPS = 0.05, 0.05


class Steered(NamedTuple):
    """Vehicles as gpsec steers them; N vehicle rows.

    Attributes:
        driven: (N,) gpsec steers; otherwise SUMO drives alone.
        offset_m: (N,) true displacement from the middle of the path, left positive; rate_mps: (N,) its rate.
        follow: (N,) what is steered by, a `Follow`.
        reacts: (N,) the reaction asks for something else than to drive on by the estimate.
        brake_mps2: (N,) 0 where the vehicle does not brake on an alarm.
        calm_step: (N,) step in which attack and reaction were over, -1 before.
    """

    driven: Flags = blank(False)
    offset_m: Floats = blank(0.0)
    rate_mps: Floats = blank(0.0)
    follow: Ints = blank(int(Follow.ESTIMATE))
    reacts: Flags = blank(False)
    brake_mps2: Floats = blank(0.0)
    calm_step: Ints = blank(-1)


class Late(NamedTuple):
    """What the steering has not come to yet; N vehicle rows: wanted_m (N, steps), by the step modulo their number."""

    wanted_m: Floats = blank(0.0, "steps")


@dataclass(frozen=True)
class Drivers:
    """What steering is told of the fleet in a step; m vehicles.

    Attributes:
        rows: (m,) vehicle rows.
        key: (m,) for counter-based noise.
        settled: (m,) on the road for long enough to be steered.
        attacked: (m,) under attack.
        alarm: (m,) in alarm, by the detector of the acting defence.
        error_m: (m,) of the estimate of that defence across the road, left positive.
        edge_m: (m,) displacement at which the vehicle stands at the edge of the road.
        speed_mps: (m,) of the vehicle.
        wrecked: (m,) nobody steers any more.
    """

    rows: Ints
    key: Keys
    settled: Flags
    attacked: Flags
    alarm: Flags
    error_m: Floats
    edge_m: Floats
    speed_mps: Floats
    wrecked: Flags


@dataclass(frozen=True)
class Wishes:
    """What SUMO is to do with the vehicles that gpsec steers.

    Attributes:
        rows: (n,) vehicle rows that are steered.
        offset_m: (n,) where to be across the road.
        brake_mps2: (n,) 0 where SUMO chooses the speed.
        released: rows that are SUMO's again from this step on.
    """

    rows: Ints
    offset_m: Floats
    brake_mps2: Floats
    released: Ints


class Steering:
    """The vehicles that gpsec steers.

    Attributes:
        everybody: all settled vehicles are steered, so that honest errors move them as well; otherwise those under
            attack and those that react.
    """

    def __init__(
        self, step_s: float, dynamics: LateralDynamics, reaction: Reaction, *, everybody: bool, delay_s: float = 0.0
    ) -> None:
        """Take the parts of a world; `delay_s` is from an estimate to the steering that goes by it."""
        self.everybody = everybody
        self._step_s = step_s
        self._dynamics, self._reaction = dynamics, reaction
        self._steered = Table(Steered)
        self._late = Table(Late, steps=1 + round(delay_s / step_s))
        self._moving, self._reacting = dynamics.new_state(1), reaction.new_state(1)

    @property
    def now(self) -> Steered:
        """The vehicles as they are steered."""
        return self._steered.now

    def enter(self, rows: Ints) -> None:
        """Begin anew in `rows`."""
        capacity = self._steered.capacity
        if int(rows.max(initial=0)) >= capacity:
            for grown in (self._steered, self._late, self._moving, self._reacting):
                grown.grow(2 * (int(rows.max()) + 1))
        for table in (self._steered, self._late, self._moving, self._reacting):
            table.reset(rows)

    def update(self, step: int, people: Drivers) -> Wishes:
        """Take in a step and return what is to be done."""
        rows, steered = people.rows, self.now
        situation = Situation(rows, people.key, step, self._step_s, people.alarm, people.speed_mps)
        conduct = self._reaction.apply(situation, self._reacting.now)
        self._take_and_keep(step, people, conduct)
        released = self._release(people)
        on = steered.driven[rows]
        self._move(step, people, on & ~people.wrecked)
        driven = rows[on]
        return Wishes(driven, steered.offset_m[driven], steered.brake_mps2[driven], released)

    def _take_and_keep(self, step: int, people: Drivers, conduct: Conduct) -> None:
        """Take control of who is attacked or reacts, and say what all who are steered follow."""
        rows, steered = people.rows, self.now
        reacts = (conduct.follow != Follow.ESTIMATE) | (conduct.brake_mps2 > 0.0)
        wanted = people.attacked | reacts | (people.settled & self.everybody)
        new = rows[wanted & ~steered.driven[rows] & ~people.wrecked]
        self._moving.reset(new)
        self._late.reset(new)
        steered.driven[new] = True
        steered.offset_m[new] = steered.rate_mps[new] = 0.0
        steered.calm_step[rows[wanted]] = -1
        calm = rows[~wanted]
        steered.calm_step[calm] = np.where(steered.calm_step[calm] < 0, step, steered.calm_step[calm])
        waited_s = (step - steered.calm_step[rows]) * self._step_s
        believed = wanted | ((np.abs(people.error_m) > _BELIEVED_M) & (waited_s < _BELIEVED_S))
        steered.follow[rows] = np.where(believed, conduct.follow, Follow.LANE)
        steered.reacts[rows], steered.brake_mps2[rows] = reacts, conduct.brake_mps2

    def _release(self, people: Drivers) -> Ints:
        rows, steered = people.rows, self.now
        calm = steered.driven[rows] & (steered.calm_step[rows] >= 0) & (steered.follow[rows] == Follow.LANE)
        back = (np.abs(steered.offset_m[rows]) < _BACK_M) & (np.abs(steered.rate_mps[rows]) < _BACK_MPS)
        released: Ints = rows[calm & back & ~people.wrecked]
        steered.driven[released] = False
        steered.offset_m[released] = steered.rate_mps[released] = 0.0
        return released

    def _move(self, step: int, people: Drivers, on: Flags) -> None:
        rows, steered = people.rows[on], self.now
        follow = steered.follow[rows]
        wanted = np.where(follow == Follow.ESTIMATE, -people.error_m[on], 0.0)
        wanted = np.where(follow == Follow.EDGE, people.edge_m[on], wanted)
        late = self._late.now.wanted_m
        late[rows, step % late.shape[1]] = wanted
        wanted = late[rows, (step + 1) % late.shape[1]]
        motion = LateralMotion(
            rows, self._step_s, steered.offset_m[rows], steered.rate_mps[rows], wanted, people.speed_mps[on]
        )
        moved = self._dynamics.apply(motion, self._moving.now)
        steered.offset_m[rows], steered.rate_mps[rows] = moved.offset_m, moved.rate_mps

"""What is kept of a closed world for its report: the stories of crashes, and a road on which somebody was stopped."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.encounters.encounters import People
from gpsec.hdmap.map import HDMap
from gpsec.outcomes.moments import Crash, LastSeconds, RoadMoment
from gpsec.outcomes.standing import StandingRoads


@dataclass(frozen=True)
class FleetNow:
    """The fleet in a step; n vehicles, the first of the people on the road.

    Attributes:
        lane: (n,) of the path.
        off_m: (n, 2) estimate of the defence that steers less the truth.
        displaced_m: (n,) from the middle of the path.
        attacked, alarm, brakes: (n,) under attack; in alarm; braking on an alarm.
    """

    lane: Ints
    off_m: Floats
    displaced_m: Floats
    attacked: Flags
    alarm: Flags
    brakes: Flags


class Kept:
    """What is kept of a world, in bounded room."""

    def __init__(self, hd_map: HDMap, step_s: float) -> None:
        self._last = LastSeconds(step_s)
        self._roads = StandingRoads(hd_map, self._last.period_s)
        self._serial = np.zeros(0, np.int64)
        self._given = 0

    def enter(self, numbers: Ints) -> None:
        """Let (n,) numbers be those of somebody else from now on."""
        missing = int(numbers.max(initial=-1)) + 1 - len(self._serial)
        if missing > 0:
            self._serial = np.concatenate([self._serial, np.zeros(2 * missing, np.int64)])
        self._serial[numbers] = np.arange(self._given, self._given + len(numbers))
        self._given += len(numbers)

    def due(self, step: int) -> bool:
        """Return whether a moment is kept of that step."""
        return self._last.due(step)

    def moment(self, time_s: float, party: People, fleet: FleetNow, wrecked: Flags) -> RoadMoment:
        """Return a moment of the road."""
        count, bodies = len(fleet.lane), party.bodies
        others = len(party.number) - count
        none = np.zeros(others, np.bool_)
        stopped = wrecked.copy()
        stopped[:count] |= fleet.brakes
        return RoadMoment(
            time_s=time_s,
            serial=self._serial[party.number],
            x_m=bodies.x_m,
            y_m=bodies.y_m,
            ux=bodies.ux,
            uy=bodies.uy,
            length_m=2.0 * bodies.half_length_m,
            width_m=2.0 * bodies.half_width_m,
            speed_mps=np.sqrt(bodies.vx_mps**2 + bodies.vy_mps**2),
            fleet=np.arange(len(party.number)) < count,
            lane=np.concatenate([fleet.lane, np.zeros(others, np.int32)]),
            off_m=np.concatenate([fleet.off_m, np.zeros((others, 2))]),
            displaced_m=np.concatenate([fleet.displaced_m, np.zeros(others)]),
            attacked=np.concatenate([fleet.attacked, none]),
            alarm=np.concatenate([fleet.alarm, none]),
            stopped=stopped,
        )

    def see(self, moment: RoadMoment) -> None:
        """Take in a moment that is due."""
        self._roads.see(moment, self._last.moments)
        self._last.see(moment)

    def tell(self, crash: Crash, now: RoadMoment) -> None:
        """Keep the story of a crash, where it is the first of its kind."""
        self._last.tell(crash, now)

    @property
    def tables(self) -> Mapping[str, Sequence[Mapping[str, Any]]]:
        """Rows of the tables of what is kept, without the columns of the world."""
        return {"crashes": self._last.stories, "standing": list(self._roads.standing), "jams": list(self._roads.jam)}

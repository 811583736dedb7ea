"""The last seconds of everybody on the road in closed loop, and the stories of crashes that are kept of them."""

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints, Longs

# Of a story: how long before the crash it begins, and how often it is sampled.
STORY_S, KEPT_EVERY_S = 20.0, 0.2


class RoadMoment(NamedTuple):
    """Everybody on the road at one time; B of them.

    Attributes:
        time_s: simulated time.
        serial: (B,) of each, never given to two.
        x_m, y_m: (B,) middle of the body in the net's frame; ux, uy: (B,) unit vector along it.
        length_m, width_m: (B,) of the body.
        speed_mps: (B,).
        fleet: (B,) part of the fleet, with an estimate; of others there is the body alone.
        lane: (B,) index of the lane that is the vehicle's path, 0 of others.
        off_m: (B, 2) estimate of the defence that steers less the truth, 0 of others.
        displaced_m: (B,) from the middle of the path, left positive.
        attacked, alarm: (B,) under attack; in alarm.
        stopped: (B,) a wreck, or braking on an alarm.
    """

    time_s: float
    serial: Longs
    x_m: Floats
    y_m: Floats
    ux: Floats
    uy: Floats
    length_m: Floats
    width_m: Floats
    speed_mps: Floats
    fleet: Flags
    lane: Ints
    off_m: Floats
    displaced_m: Floats
    attacked: Flags
    alarm: Flags
    stopped: Flags


@dataclass(frozen=True)
class Crash:
    """A hit whose story is told.

    Attributes:
        kind: of the hit.
        closing_mps: size of the relative velocity.
        vehicle_ids: of both.
        places: of both in the moment of the hit.
    """

    kind: str
    closing_mps: float
    vehicle_ids: Sequence[str]
    places: Sequence[int]


class LastSeconds:
    """The moments of the last `STORY_S`, and the first crash of each kind."""

    def __init__(self, step_s: float) -> None:
        self._every = max(1, round(KEPT_EVERY_S / step_s))
        self.period_s = self._every * step_s
        self._moments: deque[RoadMoment] = deque(maxlen=round(STORY_S / self.period_s) + 1)
        self._told: dict[str, list[dict[str, Any]]] = {}

    def due(self, step: int) -> bool:
        """Return whether a moment is kept of that step."""
        return step % self._every == 0

    @property
    def moments(self) -> Sequence[RoadMoment]:
        """Those that are held, the oldest first."""
        return tuple(self._moments)

    @property
    def stories(self) -> list[Mapping[str, Any]]:
        """Rows of `crashes.csv`, without the columns of the world."""
        return [row for rows in self._told.values() for row in rows]

    def see(self, moment: RoadMoment) -> None:
        """Take in a moment that is due."""
        self._moments.append(moment)

    def tell(self, crash: Crash, now: RoadMoment) -> None:
        """Keep the story of a crash, where it is the first of its kind; `now` is the moment of the hit."""
        if crash.kind in self._told:
            return
        before = [one for one in self._moments if one.time_s < now.time_s - 1e-9]
        self._told[crash.kind] = [
            {"kind": crash.kind, "closing_mps": crash.closing_mps, "crash_s": now.time_s, **row}
            for vehicle_id, place in zip(crash.vehicle_ids, crash.places, strict=True)
            for row in _rows(vehicle_id, int(now.serial[place]), [*before, now])
        ]


def _rows(vehicle_id: str, serial: int, moments: Sequence[RoadMoment]) -> Iterator[dict[str, Any]]:
    for moment in moments:
        for at in np.flatnonzero(moment.serial == serial).tolist():
            known = bool(moment.fleet[at])
            x_m, y_m = float(moment.x_m[at]), float(moment.y_m[at])
            yield {
                "vehicle_id": vehicle_id,
                "time_s": moment.time_s,
                "x_m": x_m,
                "y_m": y_m,
                "yaw_rad": float(np.arctan2(moment.uy[at], moment.ux[at])),
                "speed_mps": float(moment.speed_mps[at]),
                "length_m": float(moment.length_m[at]),
                "width_m": float(moment.width_m[at]),
                "displacement_m": float(moment.displaced_m[at]),
                "estimate_x_m": x_m + float(moment.off_m[at, 0]) if known else None,
                "estimate_y_m": y_m + float(moment.off_m[at, 1]) if known else None,
                "attacked": bool(moment.attacked[at]),
                "alarm": bool(moment.alarm[at]),
            }

"""The collisions of a closed world, written down as they happen."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.geo import Projector
from gpsec.encounters.encounters import SLOW_MPS, Hits
from gpsec.encounters.meeting import Kind
from gpsec.outcomes.moments import Crash, RoadMoment
from gpsec.outcomes.true_outcomes import TrueOutcomes
from gpsec.outcomes.worlds import WRECK
from gpsec.pipeline.kept import Kept
from gpsec.traffic.source import Frame

# Kinds of collisions as tables call them.
KIND_NAMES = {int(kind): kind.name.lower() for kind in Kind}


class Collisions:
    """Who hit whom, a row of a table each; outcomes and the report learn of them, too."""

    def __init__(self, names: Mapping[int, str], happened: TrueOutcomes, kept: Kept) -> None:
        """Begin with none; `names` are the ids of the vehicle rows in use, kept up to date by the caller."""
        self._names, self._happened, self._kept = names, happened, kept
        self._rows: list[dict[str, Any]] = []

    def note(self, frame: Frame, hits: Hits, now: RoadMoment, offset_m: Floats) -> None:
        """Write down the hits of a step; `offset_m` is the (N,) displacement of vehicle rows."""
        for at in range(len(hits.first)):
            self._note(frame, hits, at, now, offset_m)

    def rows(self, projector: Projector) -> list[dict[str, Any]]:
        """Return the rows, with longitude and latitude."""
        return [row | _degrees(projector, row["x_m"], row["y_m"]) for row in self._rows]

    def _note(self, frame: Frame, hits: Hits, at: int, now: RoadMoment, offset_m: Floats) -> None:
        """Write down a hit, the attacked vehicle first where there is one."""
        count = len(frame.rows)
        pair = [int(hits.first[at]), int(hits.second[at])]
        under = [place < count and self._happened.was_attacked(int(frame.rows[place])) for place in pair]
        if under[1] and not under[0]:
            pair, under = pair[::-1], under[::-1]
        names = [self._name(frame, place) for place in pair]
        first_m = float(offset_m[frame.rows[pair[0]]]) if pair[0] < count else 0.0
        x_m, y_m = (float(np.mean(axis[pair])) for axis in (now.x_m, now.y_m))
        kind, closing_mps = KIND_NAMES[int(hits.kind[at])], float(hits.closing_mps[at])
        slow = closing_mps < SLOW_MPS
        if not slow and kind != WRECK:
            self._kept.tell(Crash(kind, closing_mps, names, pair), now)
        for place in pair:
            if place < count and not slow:
                self._happened.crash(frame.step, int(frame.rows[place]), int(hits.kind[at]))
        self._rows.append(
            {
                "time_s": frame.time_s,
                "x_m": x_m,
                "y_m": y_m,
                "vehicle_id": names[0],
                "other_id": names[1],
                "kind": kind,
                "closing_mps": closing_mps,
                "attacked": under[0],
                "other_attacked": under[1],
                "displacement_m": first_m,
                "slow": slow,
            }
        )

    def _name(self, frame: Frame, place: int) -> str:
        count = len(frame.rows)
        if place < count:
            return self._names[int(frame.rows[place])]
        return frame.carried.others.sumo_id[place - count] if frame.carried else ""


def _degrees(projector: Projector, x_m: float, y_m: float) -> dict[str, float]:
    longitude, latitude = projector.to_lon_lat(np.array([x_m, y_m])).tolist()
    return {"longitude": longitude, "latitude": latitude}

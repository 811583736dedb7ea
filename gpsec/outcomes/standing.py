"""Where vehicles stand in closed loop: the time by road, and who drives on the roads on which somebody was stopped."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.hdmap.map import HDMap
from gpsec.outcomes.moments import RoadMoment
from gpsec.outcomes.true_outcomes import STANDING_MPS

# What is held at most: roads that are watched, samples of each, roads whose standing time is written.
MOST_ROADS, MOST_SAMPLES, MOST_WRITTEN = 8, 4000, 200
# Between two samples of a road; it doubles where there would be too many.
_PERIOD_S = 1.0
# Who is this far beside the outermost lane, or turned by more than 60°, is not on the road.
_BESIDE_M, _ALONG_COS = 4.0, 0.5


@dataclass
class _Road:
    """A road that is watched, from the moment in which somebody was stopped on it.

    Attributes:
        line_m: (n, 2) centre line of the lane on which that was; start_m: (n,) way along it of its points.
        right_m, left_m: how far the road goes to both sides of that line.
        samples: of each moment: its time, and serial, position, speed, stopped and attacked of those on the road.
        period_s: between two samples.
        standing_s: time for which vehicles have stood on it since.
    """

    line_m: Floats
    start_m: Floats
    right_m: float
    left_m: float
    samples: list[tuple[float, np.ndarray]] = field(default_factory=list)
    period_s: float = _PERIOD_S
    standing_s: float = 0.0

    def see(self, moment: RoadMoment) -> None:
        """Take in a moment, where a sample is due."""
        if self.samples and moment.time_s - self.samples[-1][0] < self.period_s - 1e-6:
            return
        low, high = self.line_m.min(axis=0), self.line_m.max(axis=0)
        margin = max(self.right_m, self.left_m)
        near = np.flatnonzero(
            (moment.x_m > low[0] - margin)
            & (moment.x_m < high[0] + margin)
            & (moment.y_m > low[1] - margin)
            & (moment.y_m < high[1] + margin)
        ).astype(np.int32)
        position_m, offset_m, cosine = self._project(moment, near)
        on = (offset_m > -self.right_m) & (offset_m < self.left_m) & (cosine > _ALONG_COS)
        on &= (position_m >= 0.0) & (position_m <= self.start_m[-1])
        who = near[on]
        columns = (moment.serial[who], position_m[on], moment.speed_mps[who], moment.stopped[who], moment.attacked[who])
        self.samples.append((moment.time_s, np.stack([column.astype(np.float64) for column in columns], axis=1)))
        self.standing_s += float((moment.speed_mps[who] < STANDING_MPS).sum()) * self.period_s
        if sum(len(rows) for _, rows in self.samples) > MOST_SAMPLES:
            self.samples = self.samples[::2]
            self.period_s *= 2.0

    def _project(self, moment: RoadMoment, near: Ints) -> tuple[Floats, Floats, Floats]:
        """Return (n,) way along, offset to the left and cosine of the angle to the line of those `near` it."""
        run = np.diff(self.line_m, axis=0)
        size = np.hypot(run[:, 0], run[:, 1])
        unit = run / size[:, np.newaxis]
        dx = moment.x_m[near][:, np.newaxis] - self.line_m[:-1, 0]
        dy = moment.y_m[near][:, np.newaxis] - self.line_m[:-1, 1]
        along = dx * unit[:, 0] + dy * unit[:, 1]
        beyond = along - np.clip(along, 0.0, size)
        offset = dy * unit[:, 0] - dx * unit[:, 1]
        at = np.argmin(beyond**2 + offset**2, axis=1)
        pick = np.arange(len(near)), at
        cosine = moment.ux[near] * unit[at, 0] + moment.uy[near] * unit[at, 1]
        return self.start_m[at] + along[pick], offset[pick], cosine


class StandingRoads:
    """Where the vehicles of a world stand."""

    def __init__(self, hd_map: HDMap, period_s: float) -> None:
        names = [lane_id.rpartition("_")[0] for lane_id in hd_map.lane_ids]
        self._edges = list(dict.fromkeys(names))
        number = {name: at for at, name in enumerate(self._edges)}
        self._edge = np.array([number[name] for name in names], np.int32)
        self._map, self._period_s = hd_map, period_s
        self._steps = np.zeros(len(self._edges), np.int64)
        self._roads: dict[int, _Road] = {}

    def see(self, moment: RoadMoment, before: Sequence[RoadMoment]) -> None:
        """Take in a moment; `before` are those that came earlier, of which a road is told that is new."""
        stands = moment.fleet & (moment.speed_mps < STANDING_MPS)
        np.add.at(self._steps, self._edge[moment.lane[stands]], 1)
        for lane in moment.lane[stands & moment.stopped].tolist():
            edge = int(self._edge[lane])
            if edge in self._roads or len(self._roads) == MOST_ROADS or self._map.sides.internal[lane]:
                continue
            self._roads[edge] = self._watched(lane)
            for earlier in before:
                self._roads[edge].see(earlier)
        for road in self._roads.values():
            road.see(moment)

    def _watched(self, lane: int) -> _Road:
        sides, line_m = self._map.sides, self._map.centre_line(lane)
        line_m = line_m[np.concatenate([[True], np.hypot(*np.diff(line_m, axis=0).T) > 0.0])]
        start_m = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line_m, axis=0).T))])
        half_m = 0.5 * float(sides.width_m[lane]) + _BESIDE_M
        right_m = half_m + float(sides.same_right_m[lane] + sides.oncoming_right_m[lane])
        left_m = half_m + float(sides.same_left_m[lane] + sides.oncoming_left_m[lane])
        return _Road(line_m, start_m, right_m, left_m)

    @property
    def standing(self) -> Iterator[Mapping[str, Any]]:
        """Rows of `standing.csv`, without the columns of the world: the roads on which vehicles stood longest."""
        order = np.argsort(-self._steps, kind="stable")[:MOST_WRITTEN].tolist()
        for at in sorted({*order, *self._roads}, key=lambda edge: (-int(self._steps[edge]), edge)):
            if self._steps[at]:
                yield {"road": self._edges[at], "standing_s": float(self._steps[at] * self._period_s)}

    @property
    def jam(self) -> Iterator[Mapping[str, Any]]:
        """Rows of `jams.csv`, without the columns of the world: the watched road on which vehicles stood longest."""
        if not self._roads:
            return
        edge = max(self._roads, key=lambda at: (self._roads[at].standing_s, -at))
        road = self._roads[edge]
        for time_s, rows in road.samples:
            for serial, position_m, speed_mps, stopped, attacked in rows.tolist():
                yield {
                    "road": self._edges[edge],
                    "length_m": float(road.start_m[-1]),
                    "time_s": time_s,
                    "vehicle": int(serial),
                    "position_m": position_m,
                    "speed_mps": speed_mps,
                    "stopped": bool(stopped),
                    "attacked": bool(attacked),
                }

"""By what the map in vehicles differs from the roads."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.noise import MAP_FIELD, MAP_ROAD, plain_normal, plain_uniform, vehicle_key
from gpsec.hdmap.net import Lane
from gpsec.hdmap.polyline import Polyline, measure

# Plane waves that the random field is made of.
_WAVES = 64


@dataclass(frozen=True)
class MapError:
    """How the maps in vehicles are displaced from the true centre lines, the same in all vehicles.

    Attributes:
        seed: of the random parts.
        shift_m: east and north, of the whole map.
        field_m: standard deviation, on each axis, of a displacement that varies from place to place.
        field_length_m: its correlation length: at a distance d the correlation is exp(-d²/2·length²).
        road_m: standard deviation of a displacement across the road, one draw for each road (edge); inside junctions it
            passes from that of one road into that of the next.
    """

    seed: int = 0
    shift_m: tuple[float, float] = (0.0, 0.0)
    field_m: float = 0.0
    field_length_m: float = 200.0
    road_m: float = 0.0

    def __bool__(self) -> bool:
        """Whether there is one."""
        return any(self.shift_m) or self.field_m > 0.0 or self.road_m > 0.0

    def displaced(self, lanes: Sequence[Lane], lines: Sequence[Polyline]) -> list[Polyline]:
        """Return the lines, one for each of `lanes`, as the map has them."""
        ends = self._road_ends(lanes) if self.road_m > 0.0 else {}
        return [
            measure(self._moved(line, *ends.get(lane.lane_id, (0.0, 0.0))))
            for lane, line in zip(lanes, lines, strict=True)
        ]

    def _moved(self, line: Polyline, first_m: float, last_m: float) -> Floats:
        """Return the (n, 2) points of a line that lies `first_m … last_m` left of where it should."""
        share = line.s_m / line.s_m[-1]
        left = np.stack([-np.sin(line.yaw_rad), np.cos(line.yaw_rad)], axis=1)
        across = (first_m + share * (last_m - first_m))[:, None] * left
        moved: Floats = line.points_m + np.array(self.shift_m) + self._field(line.points_m) + across
        return moved

    def _field(self, points_m: Floats) -> Floats:
        """Return the (n, 2) random field at (n, 2) points."""
        if self.field_m == 0.0:
            return np.zeros_like(points_m)
        vectors, phases = self._waves
        # Σ √(2/K) cos(k·p + φ) has variance 1; k is normal with deviation 1/length (Rahimi and Recht, NIPS 2007).
        waves = np.cos(np.einsum("nd,akd->nak", points_m, vectors) + phases)
        field: Floats = self.field_m * sqrt(2.0 / _WAVES) * waves.sum(axis=2)
        return field

    @cached_property
    def _waves(self) -> tuple[Floats, Floats]:
        """Wave vectors (2, K, 2) and phases (2, K) of the field's east and north component."""
        key = vehicle_key(self.seed, "map field")
        draws = np.array([plain_normal(key, MAP_FIELD, number) for number in range(4 * _WAVES)])
        phases = np.array([plain_uniform(key, MAP_FIELD, 4 * _WAVES + number) for number in range(2 * _WAVES)])
        return draws.reshape(2, _WAVES, 2) / self.field_length_m, 2.0 * pi * phases.reshape(2, _WAVES)

    def _road_ends(self, lanes: Sequence[Lane]) -> dict[str, tuple[float, float]]:
        """Return the displacement of each lane to its left, at its start and at its end."""
        of = {lane.lane_id: lane for lane in lanes}
        before: dict[str, str] = {}
        for lane in lanes:
            for successor in lane.successors:
                before.setdefault(successor, lane.lane_id)

        def road(lane: Lane, forwards: bool) -> float:
            """Return the draw of the first road behind or ahead of an internal lane."""
            passed = {lane.lane_id}
            while lane.internal:
                found = lane.successors[0] if forwards and lane.successors else before.get(lane.lane_id, "")
                if not found or found in passed:
                    return 0.0
                passed.add(found)
                lane = of[found]
            return self._road(lane)

        ends = {}
        for lane in lanes:
            first, last = road(lane, False), road(lane, True)
            middle = 0.5 * (first + last)
            behind, ahead = of.get(before.get(lane.lane_id, "")), of.get(next(iter(lane.successors), ""))
            if lane.internal and behind is not None and behind.internal:
                first = middle
            if lane.internal and ahead is not None and ahead.internal:
                last = middle
            ends[lane.lane_id] = first, last
        return ends

    def _road(self, lane: Lane) -> float:
        key = vehicle_key(self.seed, lane.lane_id.rpartition("_")[0])
        return self.road_m * plain_normal(key, MAP_ROAD, 0)


EXACT = MapError()
"""The map in vehicles is that of the roads."""

"""The lane that one track believes to be on, by hand: a dictionary of lanes, with matrices from numpy."""

from dataclasses import dataclass, replace
from math import atan, ceil, cos

import numpy as np

from gpsec.association.evidence import (
    AT_LINE_M,
    BEND_PER_M,
    CONTRADICTION_M,
    CROSSED_M,
    EDGE_SIGMA_M,
    HEADING_SIGMA,
    LEAST_BLIND,
    LEAST_OFFSET,
    LEAST_SLOPE,
    NEIGHBOUR,
    SLOPE_SAMPLES,
    SLOPE_SIGMA,
    SURPRISE,
    SURPRISE_M,
    SUSPICIOUS,
    UNSURE,
)
from gpsec.association.geometry import FAR
from gpsec.association.state import HYPOTHESES
from gpsec.association.tracked import (
    AS_LIKELY,
    BIAS_SAMPLES,
    BLIND_S,
    DROP,
    SETTLING_S,
    START_M,
    STRIKES,
    TRUSTED,
)
from gpsec.core.arrays import Floats
from gpsec.filters.noise import LASTING_ERROR_S, FilterNoise
from gpsec.hdmap.search import MIN_COS
from gpsec.reference.filters import wrapped
from gpsec.reference.free_filter import FreeFilter, turned
from gpsec.reference.lane_line import Beside, LaneLine, LaneLines
from gpsec.reference.sight import Sight


@dataclass
class Hypothesis:
    """One lane that the track may be on.

    Attributes:
        segment: number of the segment of that lane that it is beside.
        position_m: (2,) of the rear axle.
        covariance: (2, 2) of it.
        weight: logarithm of its likelihood over that of the best.
    """

    segment: int
    position_m: Floats
    covariance: Floats
    weight: float

    def correct(self, h: Floats, innovation: float, variance: float) -> None:
        """Correct by what was seen of h · position."""
        gain = self.covariance @ h / (h @ self.covariance @ h + variance)
        self.position_m = self.position_m + gain * innovation
        self.covariance = self.covariance - np.outer(gain, h @ self.covariance)


class TrackAssociation:
    """The lane of one track.

    Attributes:
        hypotheses: the lanes that it may be on.
        best: the lane that it believes to be on, None before the first fix.
        known: no other lane is nearly as likely.
        unmatched: the camera sees a lane in this step that no hypothesis explains.
    """

    def __init__(self, lines: LaneLines, noise: FilterNoise[float], step_s: float) -> None:
        self._lines = lines
        self._map = lines.hd_map
        self._noise = noise
        self._step_s = step_s
        self._free: FreeFilter | None = None
        self.hypotheses: dict[int, Hypothesis] = {}
        self._begun = False
        self._settling = 0
        self._blind_s = 0.0
        self._strikes = 0
        self.best: int | None = None
        self.known = False
        self.unmatched = False

    def step(self, sight: Sight) -> None:
        """Take one step."""
        self.unmatched = False
        if self._free is None:
            if sight.fix_m is None:
                return
            self._free = FreeFilter(self._noise, sight.fix_m)
            self._begin(sight.fix_m, sight.heading_rad)
        else:
            self._move(self._free, sight)
            if sight.fix_m is not None:
                self._free.take(sight.fix_m)
                self._use_fix(self._free, sight.fix_m)
        if sight.lane_offset_m is not None:
            if self._blind_s > BLIND_S:
                self._look_again(self._free, sight.lane_offset_m, sight.camera_sigma_m, sight.heading_rad)
            self._blind_s = 0.0
            self._use_camera(sight, sight.lane_offset_m)
        else:
            self._blind_s += self._step_s
            self._use_heading(sight.heading_rad)
        self._settle(self._free, sight.heading_rad)

    def _line(self, lane: int) -> LaneLine:
        return self._lines[lane]

    def _width(self, lane: int) -> float:
        return float(self._map.sides.width_m[lane])

    def _beside(self, lane: int, one: Hypothesis, heading_rad: float) -> Beside:
        return self._line(lane).beside(one.segment, one.position_m, heading_rad)

    def _propose(self, lane: int, new: Hypothesis) -> None:
        if lane not in self.hypotheses and len(self.hypotheses) == HYPOTHESES:
            worst = min(self.hypotheses, key=lambda other: self.hypotheses[other].weight)
            if self.hypotheses[worst].weight >= new.weight:
                return
            del self.hypotheses[worst]
        if lane not in self.hypotheses or self.hypotheses[lane].weight < new.weight:
            self.hypotheses[lane] = new

    def _begin(self, position_m: Floats, heading_rad: float) -> None:
        noise = self._noise
        self.hypotheses = {}
        self._strikes = 0
        self._settling = ceil(SETTLING_S / noise.gnss_period_s)
        spread = (noise.gnss_white_m**2 + noise.gnss_bias_m**2) * np.eye(2)
        reach_m = START_M * (2.0 if self._begun else 1.0)
        for lane in range(len(self._map.lane_ids)):
            for segment, distance_m in self._line(lane).within(position_m, heading_rad, reach_m):
                self._propose(lane, Hypothesis(segment, position_m, spread, -FAR * distance_m**2))

    def _move(self, free: FreeFilter, sight: Sight) -> None:
        turn = sight.yaw_rate_rps * self._step_s
        way = free.way(sight.speed_mps, turn, sight.heading_rad, self._step_s)
        free.predict(sight.speed_mps, turn, sight.heading_rad, self._step_s)
        lasting = sight.speed_mps**2 * self._step_s * LASTING_ERROR_S
        along = (self._noise.odometer_white_mps * self._step_s) ** 2 + free.scale_variance * lasting
        across = self._noise.heading_rad**2 * lasting
        Q = turned(along, across, sight.heading_rad - turn / 2.0)
        waiting = []
        for lane, one in self.hypotheses.items():
            one.position_m = one.position_m + way
            one.covariance = one.covariance + Q
            waiting.append((lane, one))
        self.hypotheses = {}
        graph = self._map.graph
        while waiting:
            lane, one = waiting.pop(0)
            one.segment, passed = self._line(lane).walk(one.segment, one.position_m)
            first, count = int(graph.after_first[lane]), int(graph.after_count[lane])
            if not passed or count == 0:
                self._propose(lane, one)
                continue
            for after in graph.after_lane[first : first + count].tolist():
                waiting.append((after, replace(one, segment=0)))

    def _use_fix(self, free: FreeFilter, fix_m: Floats) -> None:
        if free.accepted < (TRUSTED if self._begun else 1):
            return
        settling = self._settling > 0
        if settling:
            self._settling -= 1
            self._begun = self._begun or self._settling == 0
        variance = free.white_variance + BIAS_SAMPLES * self._noise.gnss_bias_m**2
        for lane, one in self.hypotheses.items():
            along = self._line(lane).direction[one.segment]
            one.correct(along, float(along @ (fix_m - one.position_m)), variance)
            if settling:
                across = np.array([-along[1], along[0]])
                one.correct(across, float(across @ (fix_m - one.position_m)), variance)

    def _best(self) -> int | None:
        lanes = self.hypotheses
        return max(lanes, key=lambda lane: lanes[lane].weight) if lanes else None

    def _look_again(self, free: FreeFilter, offset_m: float, sigma_m: float, heading_rad: float) -> None:
        best = self._best()
        if best is None:
            return
        one = self.hypotheses[best]
        at = self._beside(best, one, heading_rad)
        across = float(at.left @ one.covariance @ at.left)
        off = self._from_expected(best, at.offset_m * cos(at.turn_rad), offset_m * cos(at.turn_rad))
        surprised = off**2 > SURPRISE * (across + sigma_m**2) and abs(off) > SURPRISE_M
        if not surprised and across <= (UNSURE * self._width(best)) ** 2:
            return
        self._settling = ceil(SETTLING_S / self._noise.gnss_period_s)
        if surprised:
            free.doubt(off**2)
            for one in self.hypotheses.values():
                one.covariance = one.covariance + off**2 * np.eye(2)
        for lane, one in list(self.hypotheses.items()):
            self._propose_neighbour(lane, one, True, one.weight, heading_rad)
            self._propose_neighbour(lane, one, False, one.weight, heading_rad)

    def _from_expected(self, lane: int, expected_m: float, seen_m: float) -> float:
        graph, half_m = self._map.graph, self._width(lane) / 2.0
        least = seen_m - expected_m
        for other, line_m in ((int(graph.left[lane]), half_m), (int(graph.right[lane]), -half_m)):
            if other >= 0 and abs(expected_m - line_m) <= AT_LINE_M:
                centre_m = line_m + np.sign(line_m) * self._width(other) / 2.0
                least = min(least, seen_m - (expected_m - centre_m), key=abs)
        return float(least)

    def _propose_neighbour(self, lane: int, one: Hypothesis, left: bool, weight: float, heading_rad: float) -> None:
        graph = self._map.graph
        other = int((graph.left if left else graph.right)[lane])
        if other < 0:
            return
        segment = self._line(other).nearest(one.position_m, heading_rad)
        if segment is not None:
            self._propose(other, Hypothesis(segment, one.position_m, one.covariance, weight))

    def _use_camera(self, sight: Sight, offset_m: float) -> None:
        heading, sigma, slope = sight.heading_rad, sight.camera_sigma_m, atan(sight.lane_slope)
        before = list(self.hypotheses.items())
        for lane, one in before:
            at = self._beside(lane, one, heading)
            off = offset_m - at.offset_m
            if cos(at.turn_rad) >= MIN_COS and abs(off) > SUSPICIOUS * self._width(lane):
                self._propose_neighbour(lane, one, off < 0.0, one.weight + NEIGHBOUR, heading)
        explained = False
        white = SLOPE_SIGMA**2
        for lane, one in self.hypotheses.items():
            at = self._beside(lane, one, heading)
            if cos(at.turn_rad) < MIN_COS:
                one.weight += LEAST_OFFSET
                continue
            off = offset_m - at.offset_m
            explained = explained or abs(off) <= CONTRADICTION_M
            ahead = np.array([at.left[1], -at.left[0]])
            variance = float(at.left @ one.covariance @ at.left) + sigma**2
            slip = wrapped(slope - at.turn_rad)
            spread = white + at.curvature_per_m**2 * float(ahead @ one.covariance @ ahead)
            one.weight += max(-(off**2) / 2.0 / variance, LEAST_OFFSET)
            one.weight += max(-(slip**2) / 2.0 / spread, LEAST_SLOPE)
            if off**2 < max(self._width(lane) ** 2 / 4.0, 4.0 * variance):
                one.correct(at.left, off * cos(at.turn_rad), sigma**2)
                if abs(at.curvature_per_m) > BEND_PER_M:
                    one.correct(at.curvature_per_m * ahead, slip, SLOPE_SAMPLES * white)
        self.unmatched = not explained

    def _use_heading(self, heading_rad: float) -> None:
        for lane, one in list(self.hypotheses.items()):
            at = self._beside(lane, one, heading_rad)
            beyond = max(abs(at.offset_m) - self._width(lane) / 2.0, 0.0)
            variance = float(at.left @ one.covariance @ at.left) + EDGE_SIGMA_M**2
            cost = -((at.turn_rad / HEADING_SIGMA) ** 2) / 2.0 - beyond**2 / 2.0 / variance
            one.weight += max(cost, LEAST_BLIND)
        for lane, one in list(self.hypotheses.items()):
            at = self._beside(lane, one, heading_rad)
            beyond = abs(at.offset_m) - self._width(lane) / 2.0
            if beyond > CROSSED_M and cos(at.turn_rad) >= MIN_COS:
                self._propose_neighbour(lane, one, at.offset_m > 0.0, one.weight, heading_rad)

    def _settle(self, free: FreeFilter | None, heading_rad: float) -> None:
        best = self._best()
        if best is None or free is None:
            self.best, self.known = None, False
            if free is not None:
                self._begin(free.position_m.copy(), heading_rad)
            return
        top, position_m = self.hypotheses[best].weight, self.hypotheses[best].position_m
        self._strikes = self._strikes + 1 if self.unmatched else 0
        for one in self.hypotheses.values():
            one.weight -= top
        self.hypotheses = {lane: one for lane, one in self.hypotheses.items() if one.weight >= DROP}
        self.known = all(lane == best or one.weight <= AS_LIKELY for lane, one in self.hypotheses.items())
        self.best = best
        if self._strikes >= STRIKES:
            self._begin(position_m, heading_rad)

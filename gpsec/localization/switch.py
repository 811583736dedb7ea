"""The switch between normal operation and isolation, for every defence of every track.

On an alarm, or when fixes stop coming, a defence isolates GNSS. It re-joins when its detector has been quiet for
`hold_s` and fixes have agreed with what the vehicle knows for `rejoin_s`: laterally by the residual, along the lane by
the distance from the estimate to the fix that the residual is of, carried on to now.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, sin

import numpy as np

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.localization import ekf, learning, ukf
from gpsec.localization.history import SNAPSHOTS, History, Recall, keep, record
from gpsec.localization.noise import FilterNoise
from gpsec.localization.responses import Cells, Response, World
from gpsec.localization.state import STATES, FilterArrays, FilterState, part
from gpsec.types.tracks import SAMPLE_S, Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# Called with the name of what was done since the last call.
Lap = Callable[[str], None]

# A fix agrees with the estimate within this many standard deviations …
_GATE_SIGMAS = 3.0
# … plus this much along the lane, which an attack may have put into the estimate before it was seen.
_GATE_ALONG_M = 1.0
# Fixes count as lost after this many periods, whatever `outage_s` says.
_OUTAGE_PERIODS = 2.5


@dataclass(frozen=True)
class SwitchSettings:
    """When GNSS is given up and taken back.

    Attributes:
        hold_s: isolation lasts at least this long after the last alarm.
        rejoin_s: fixes must have agreed for this long.
        outage_s: without a fix for this long, GNSS counts as lost.
        rollback_s: responses that roll back restart from at least this long ago.

    """

    hold_s: float = 2.0
    rejoin_s: float = 1.0
    outage_s: float = 0.5
    rollback_s: float = 6.0


class Localization:
    """Runs the filters of all defences.

    Attributes:
        detector: (D,) column of the alarm that each defence listens to.
        responses: its response.
        world, settings: what they work with.
        recall: how far back responses go that roll back.

    """

    def __init__(self, detector: Ints, responses: list[Response], world: World, settings: SwitchSettings) -> None:
        self.detector = detector
        self.responses = responses
        self.world = world
        self.settings = settings
        kinds = list(dict.fromkeys(responses))
        # Which response each defence has, by number; -1 where it never isolates.
        self._kind = np.array([kinds.index(one) if one.isolates else -1 for one in responses], np.int32)
        self._isolating = [(number, kind) for number, kind in enumerate(kinds) if kind.isolates]
        self._learns = np.array([one.learns for one in responses], np.bool_)
        self._rolls_back = np.array([one.rolls_back for one in responses], np.bool_)
        self.recall = Recall.over(settings.rollback_s, world.step_s)
        # Filters of the same sort are in the same state until something happens.
        sorts = [(one.learns, one.rolls_back) for one in responses]
        self._leader = [sorts.index(sort) for sort in sorts]

    def new_state(self, capacity: int) -> FilterState:
        """Return filters for `capacity` track rows that have not started."""
        states = learning.LEARNING_STATES if self._learns.any() else STATES
        return FilterState.empty(capacity, self._leader, states, np.flatnonzero(self._rolls_back).tolist(), SNAPSHOTS)

    def new_history(self) -> Table[History]:
        """Return a history in which nothing is recorded; it grows with the vehicles."""
        return Table(History, steps=self.recall.steps)

    def step(
        self,
        filters: FilterState,
        history: Table[History],
        rows: Ints,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        alarm: Flags,
        threads: Threads,
        lap: Lap = lambda stage: None,
    ) -> None:
        """Take one step with the track rows `rows`; `alarm` is (M, K), and `lap` is told what was done."""
        if self._rolls_back.any():
            record(rows, history, tracks, vehicles, seen)
        threads.run(self._propagate, rows, filters, tracks, vehicles, seen, alarm)
        lap("EKF")
        isolated = rows[filters.isolated[rows].any(axis=1)]
        if len(isolated):
            threads.run(self._correct, isolated, filters, history, tracks, vehicles, seen, alarm)
        lap("UKF")

    def _room(self) -> Ints:
        """Return room for a kernel to work in: what each defence does, and whose filter it had before."""
        return np.empty((2, len(self.responses)), np.int32)

    def _propagate(
        self,
        rows: Ints,
        filters: FilterState,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        alarm: Flags,
    ) -> None:
        """Isolate who has to be, move all estimates on, and correct those that trust GNSS."""
        world, settings = self.world, self.settings
        _propagate(
            rows,
            self.detector,
            self._kind,
            self._learns,
            self._rolls_back,
            alarm,
            world.noise,
            world.step_s,
            settings.outage_s,
            self.recall.interval,
            self._room(),
            filters.arrays(),
            tracks.vehicle,
            tracks.fix_m,
            tracks.fix_valid,
            vehicles.profile,
            seen.speed_mps,
            seen.yaw_rate_rps,
            seen.heading_rad,
        )

    def _correct(
        self,
        rows: Ints,
        filters: FilterState,
        history: Table[History],
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        alarm: Flags,
    ) -> None:
        """Correct the isolated estimates of `rows`, all of which have one, and take GNSS back where it is time."""
        world, settings = self.world, self.settings
        alone = filters.isolated[rows] & (filters.leader[rows] == np.arange(len(self.responses)))
        for number, response in self._isolating:
            at, defence = np.nonzero(alone & (self._kind == number))
            row, column = rows[at], defence.astype(np.int32)
            if len(row):
                cells = Cells(row, column, filters.entered[row, column])
                if response.rolls_back:
                    self._rewind(response, cells, filters, history, tracks, vehicles)
                response.correct(cells, filters, tracks, vehicles, seen, world)
        _rejoin(
            rows,
            self.detector,
            self._learns,
            alarm,
            world.noise,
            world.step_s,
            settings.hold_s,
            settings.rejoin_s,
            settings.outage_s,
            self._room(),
            filters.arrays(),
            tracks.vehicle,
            tracks.paired_m,
            tracks.residual_m,
            tracks.residual_valid,
            vehicles.profile,
        )

    def _rewind(
        self,
        response: Response,
        cells: Cells,
        filters: FilterState,
        history: Table[History],
        tracks: Tracks,
        vehicles: Vehicles,
    ) -> None:
        """Let those cells go back that an alarm has isolated in this step; fixes that were lost have spoilt nothing."""
        world = self.world
        period_s = world.noise.gnss_period_s[vehicles.profile[tracks.vehicle[cells.row]]]
        lost = filters.fix_age_s[cells.row] > np.maximum(self.settings.outage_s, _OUTAGE_PERIODS * period_s)
        back = cells.entered & ~lost
        if back.any():
            alarmed = Cells(cells.row[back], cells.defence[back], cells.entered[back])
            response.rewind(alarmed, filters, history.now, tracks, vehicles, world, self.recall)


@kernel
def _propagate(
    rows: Ints,
    detector: Ints,
    kind: Ints,
    learns: Flags,
    rolls_back: Flags,
    alarm: Flags,
    table: FilterNoise[Floats],
    step_s: float,
    outage_s: float,
    interval: int,
    room: Ints,
    filters: FilterArrays,
    vehicle: Ints,
    fix_m: Floats,
    fix_valid: Flags,
    profile: Ints,
    speed_mps: Floats,
    yaw_rate_rps: Floats,
    heading_rad: Floats,
) -> None:
    # What each defence does in this step: the number of the response that it begins with, or -1.
    begins, before = room[0], room[1]
    for row in rows:
        v = vehicle[row]
        q = profile[v]
        x = fix_m[row, 0]
        y = fix_m[row, 1]
        if not filters.started[row]:
            if fix_valid[row]:
                filters.started[row] = True
                for d in range(len(detector)):
                    if learns[d]:
                        learning.start(filters.mean[row, d], filters.covariance[row, d], table, q, x, y, heading_rad[v])
                    else:
                        ekf.start(filters.mean[row, d], filters.covariance[row, d], table, q, x, y, heading_rad[v])
            continue
        for d in range(len(detector)):
            if rolls_back[d] and filters.leader[row, d] == d:
                keep(filters, row, d, filters.steps[row], interval, filters.isolated[row, d])
        filters.steps[row] += 1
        filters.fix_age_s[row] = 0.0 if fix_valid[row] else filters.fix_age_s[row] + step_s
        lost = _is_lost(filters.fix_age_s[row], outage_s, table.gnss_period_s[q])
        any_begins = False
        for d in range(len(detector)):
            begins[d] = -1
            filters.entered[row, d] = False
            if kind[d] >= 0 and not filters.isolated[row, d] and (alarm[row, detector[d]] or lost):
                begins[d] = kind[d]
                any_begins = True
        if any_begins:
            part(filters, row, begins, before)
        for d in range(len(detector)):
            leads = filters.leader[row, d] == d
            mean = filters.mean[row, d]
            covariance = filters.covariance[row, d]
            if begins[d] >= 0:
                filters.entered[row, d] = True
                filters.isolated[row, d] = True
                filters.quiet_s[row, d] = 0.0
                if leads:
                    filters.consistent_s[row, d] = 0.0
                    filters.isolated_way_m[row, d] = 0.0
                    filters.segment[row, d] = -1
                    # The filter has not turned yet in this step.
                    heading = heading_rad[v] - yaw_rate_rps[v] * step_s
                    if learns[d]:
                        learning.isolate(mean, covariance, table, q)
                        if not lost:
                            learning.drop_polluted_yaw(mean, covariance, heading, table.heading_rad[q])
                    elif not lost:
                        ukf.drop_polluted_yaw(mean, covariance, heading, table.heading_rad[q])
            if not leads:
                continue
            filters.innovation_valid[row, d] = False
            isolated = filters.isolated[row, d]
            if learns[d]:
                learning.predict(mean, covariance, table, q, speed_mps[v], yaw_rate_rps[v], step_s, isolated)
            elif isolated:
                ukf.predict(mean, covariance, table, q, speed_mps[v], yaw_rate_rps[v], step_s)
            else:
                ekf.predict(mean, covariance, table, q, speed_mps[v], yaw_rate_rps[v], step_s)
            if isolated:
                filters.isolated_way_m[row, d] += abs(speed_mps[v]) * step_s
            elif fix_valid[row]:
                innovation = filters.innovation[row, d]
                white_m = table.gnss_white_m[q]
                if learns[d]:
                    filters.repairs[row, d] += learning.update(mean, covariance, innovation, x, y, white_m)
                else:
                    filters.repairs[row, d] += ekf.update(mean, covariance, innovation, x, y, white_m)
                filters.innovation_valid[row, d] = True


@inline
def _is_lost(fix_age_s: float, outage_s: float, period_s: float) -> bool:
    return fix_age_s > max(outage_s, _OUTAGE_PERIODS * period_s)


@kernel
def _rejoin(
    rows: Ints,
    detector: Ints,
    learns: Flags,
    alarm: Flags,
    table: FilterNoise[Floats],
    step_s: float,
    hold_s: float,
    rejoin_s: float,
    outage_s: float,
    room: Ints,
    filters: FilterArrays,
    vehicle: Ints,
    paired_m: Floats,
    residual_m: Floats,
    residual_valid: Flags,
    profile: Ints,
) -> None:
    joins, before = room[0], room[1]
    for row in rows:
        q = profile[vehicle[row]]
        x = paired_m[row, 0]
        y = paired_m[row, 1]
        lost = _is_lost(filters.fix_age_s[row], outage_s, table.gnss_period_s[q])
        comparable = residual_valid[row]
        any_joins = False
        for d in range(len(detector)):
            joins[d] = 0
            if not filters.isolated[row, d]:
                continue
            filters.quiet_s[row, d] = 0.0 if alarm[row, detector[d]] or lost else filters.quiet_s[row, d] + step_s
            leader = filters.leader[row, d]
            if leader == d:
                if lost:
                    filters.consistent_s[row, d] = 0.0
                if comparable:
                    agrees = abs(residual_m[row]) <= _GATE_SIGMAS * table.residual_m[q] and _is_near(
                        filters, row, d, learns[d], table, q, x, y
                    )
                    agreed_s = filters.consistent_s[row, d] + max(table.gnss_period_s[q], SAMPLE_S, step_s)
                    filters.consistent_s[row, d] = agreed_s if agrees else 0.0
            # Half a step of tolerance: sums of steps do not meet round figures exactly.
            quiet = filters.quiet_s[row, d] >= hold_s - 0.5 * step_s
            if comparable and quiet and filters.consistent_s[row, leader] >= rejoin_s - 0.5 * step_s:
                joins[d] = 1
                any_joins = True
        if not any_joins:
            continue
        part(filters, row, joins, before)
        for d in range(len(detector)):
            if joins[d] == 1:
                filters.isolated[row, d] = False
                if filters.leader[row, d] == d:
                    _trust_again(filters, row, d, learns[d], table, q, x, y)


@inline
def _along(filters: FilterArrays, row: int, d: int, x_m: float, y_m: float) -> tuple[float, float, float]:
    """Return the direction of the estimate's yaw, and how far along it the fix lies ahead of the estimate."""
    mean = filters.mean[row, d]
    ux = cos(mean[2])
    uy = sin(mean[2])
    return ux, uy, (x_m - mean[0]) * ux + (y_m - mean[1]) * uy


@inline
def _drift(filters: FilterArrays, row: int, d: int, learns: bool, table: FilterNoise[Floats], profile: int) -> float:
    """Return the variance along the way that the odometer's scale error has made in isolation.

    A filter that has learnt its scale has this in its covariance.
    """
    if learns:
        return 0.0
    return float((table.odometer_scale[profile] * filters.isolated_way_m[row, d]) ** 2)


@inline
def _is_near(
    filters: FilterArrays,
    row: int,
    d: int,
    learns: bool,
    table: FilterNoise[Floats],
    profile: int,
    x_m: float,
    y_m: float,
) -> bool:
    P = filters.covariance[row, d]
    ux, uy, along = _along(filters, row, d, x_m, y_m)
    variance = P[0, 0] * ux * ux + 2.0 * P[0, 1] * ux * uy + P[1, 1] * uy * uy
    variance += (
        _drift(filters, row, d, learns, table, profile)
        + table.gnss_white_m[profile] ** 2
        + table.gnss_bias_m[profile] ** 2
    )
    return bool(max(abs(along) - _GATE_ALONG_M, 0.0) <= _GATE_SIGMAS * variance**0.5)


@inline
def _trust_again(
    filters: FilterArrays,
    row: int,
    d: int,
    learns: bool,
    table: FilterNoise[Floats],
    profile: int,
    x_m: float,
    y_m: float,
) -> None:
    """Let GNSS move the estimate along the lane by what was found; its slow error is as unknown as at the start."""
    m = filters.mean[row, d]
    P = filters.covariance[row, d]
    ux, uy, along = _along(filters, row, d, x_m, y_m)
    widened = _drift(filters, row, d, learns, table, profile) + along * along
    P[0, 0] += widened * ux * ux
    P[0, 1] += widened * ux * uy
    P[1, 0] = P[0, 1]
    P[1, 1] += widened * uy * uy
    if learns:
        learning.trust_again(m, P, table, profile)
        return
    bias = table.gnss_bias_m[profile] ** 2
    m[3] = 0.0
    m[4] = 0.0
    for a in range(5):
        for b in range(5):
            if a != b and (a > 1 or b > 1):
                P[a, b] = 0.0
    P[3, 3] = bias
    P[4, 4] = bias

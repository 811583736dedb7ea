"""The switch between normal operation and isolation, for every defence of every track.

On an alarm, or when fixes stop coming, a defence isolates GNSS. It re-joins when its detector has been quiet for
`hold_s` and fixes have agreed with what the vehicle knows for `rejoin_s`: laterally by the residual, along the lane by
the distance to the estimate.
"""

from dataclasses import dataclass
from math import cos, sin

import numpy as np

from gpsec.arrays import Flags, Floats, Ints
from gpsec.fleet import Measurements, Tracks, Vehicles
from gpsec.geo import wrap_angle
from gpsec.kernels import inline, kernel
from gpsec.localization import ekf, ukf
from gpsec.localization.noise_table import NoiseTable
from gpsec.localization.responses import Cells, Response, World
from gpsec.localization.state import FilterState
from gpsec.threads import Threads

# A fix agrees with the estimate within this many standard deviations …
_GATE_SIGMAS = 3.0
# … plus this much along the lane, which an attack may have put into the estimate before it was seen.
_GATE_ALONG_M = 1.0
# A yaw that is further from the heading sensor's, in standard deviations of that, has been turned by fixes.
_YAW_SIGMAS = 4.0
# Fixes count as lost after this many periods, whatever `outage_s` says.
_OUTAGE_PERIODS = 2.5


@dataclass(frozen=True)
class SwitchSettings:
    """When GNSS is given up and taken back.

    Attributes:
        hold_s: isolation lasts at least this long after the last alarm.
        rejoin_s: fixes must have agreed for this long.
        outage_s: without a fix for this long, GNSS counts as lost.

    """

    hold_s: float = 2.0
    rejoin_s: float = 1.0
    outage_s: float = 0.5


class Localization:
    """Runs the filters of all defences.

    Attributes:
        detector: (D,) column of the alarm that each defence listens to.
        responses: its response.
        world, settings: what they work with.

    """

    def __init__(self, detector: Ints, responses: list[Response], world: World, settings: SwitchSettings) -> None:
        self.detector = detector
        self.responses = responses
        self.world = world
        self.settings = settings
        self._isolates = np.array([response.isolates for response in responses])
        self._columns = {
            response: np.array([other is response for other in responses]) for response in dict.fromkeys(responses)
        }

    def new_state(self, capacity: int) -> FilterState:
        """Return filters for `capacity` track rows that have not started."""
        return FilterState.empty(capacity, len(self.responses))

    def step(
        self,
        filters: FilterState,
        rows: Ints,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        alarm: Flags,
        threads: Threads,
    ) -> None:
        """Take one step with the track rows `rows`; `alarm` is (M, K)."""
        world, settings = self.world, self.settings
        before = filters.isolated[rows]
        threads.run(
            _propagate,
            rows,
            self.detector,
            self._isolates,
            alarm,
            world.table,
            world.step_s,
            settings.outage_s,
            filters.started,
            filters.fix_age_s,
            filters.mean,
            filters.covariance,
            filters.isolated,
            filters.quiet_s,
            filters.consistent_s,
            filters.isolated_way_m,
            filters.segment,
            filters.innovation,
            filters.innovation_valid,
            filters.repairs,
            tracks.vehicle,
            tracks.fix_m,
            tracks.fix_valid,
            vehicles.profile,
            seen.speed_mps,
            seen.yaw_rate_rps,
            seen.heading_rad,
        )
        isolated = filters.isolated[rows]
        if not isolated.any():
            return
        for response, columns in self._columns.items():
            at, defence = np.nonzero(isolated & columns)
            cells = Cells(rows[at], defence.astype(np.int32), ~before[at, defence])
            if len(at):
                response.correct(cells, filters, tracks, vehicles, seen, world)
        at, defence = np.nonzero(isolated)
        _rejoin(
            rows[at],
            defence.astype(np.int32),
            self.detector,
            alarm,
            world.table,
            world.step_s,
            settings.hold_s,
            settings.rejoin_s,
            settings.outage_s,
            filters.fix_age_s,
            filters.mean,
            filters.covariance,
            filters.isolated,
            filters.quiet_s,
            filters.consistent_s,
            filters.isolated_way_m,
            tracks.vehicle,
            tracks.fix_m,
            tracks.fix_valid,
            tracks.residual_m,
            tracks.residual_valid,
            vehicles.profile,
        )


@kernel
def _propagate(
    rows: Ints,
    detector: Ints,
    isolates: Flags,
    alarm: Flags,
    table: NoiseTable,
    step_s: float,
    outage_s: float,
    started: Flags,
    fix_age_s: Floats,
    mean: Floats,
    covariance: Floats,
    isolated: Flags,
    quiet_s: Floats,
    consistent_s: Floats,
    isolated_way_m: Floats,
    segment: Ints,
    innovation: Floats,
    innovation_valid: Flags,
    repairs: Ints,
    vehicle: Ints,
    fix_m: Floats,
    fix_valid: Flags,
    profile: Ints,
    speed_mps: Floats,
    yaw_rate_rps: Floats,
    heading_rad: Floats,
) -> None:
    for row in rows:
        v = vehicle[row]
        q = profile[v]
        x = fix_m[row, 0]
        y = fix_m[row, 1]
        if not started[row]:
            if fix_valid[row]:
                started[row] = True
                for d in range(len(detector)):
                    ekf.start(mean[row, d], covariance[row, d], table, q, x, y, heading_rad[v])
            continue
        fix_age_s[row] = 0.0 if fix_valid[row] else fix_age_s[row] + step_s
        lost = fix_age_s[row] > max(outage_s, _OUTAGE_PERIODS * table.gnss_period_s[q])
        for d in range(len(detector)):
            innovation_valid[row, d] = False
            if isolates[d] and not isolated[row, d] and (alarm[row, detector[d]] or lost):
                isolated[row, d] = True
                quiet_s[row, d] = 0.0
                consistent_s[row, d] = 0.0
                isolated_way_m[row, d] = 0.0
                segment[row, d] = -1
                if not lost:
                    # The filter has not turned yet in this step.
                    heading = heading_rad[v] - yaw_rate_rps[v] * step_s
                    _drop_polluted_yaw(mean[row, d], covariance[row, d], heading, table.heading_rad[q])
            if isolated[row, d]:
                ukf.predict(mean[row, d], covariance[row, d], table, q, speed_mps[v], yaw_rate_rps[v], step_s)
                isolated_way_m[row, d] += abs(speed_mps[v]) * step_s
                continue
            ekf.predict(mean[row, d], covariance[row, d], table, q, speed_mps[v], yaw_rate_rps[v], step_s)
            if fix_valid[row]:
                white = table.gnss_white_m[q]
                repairs[row, d] += ekf.update(mean[row, d], covariance[row, d], innovation[row, d], x, y, white)
                innovation_valid[row, d] = True


@inline
def _drop_polluted_yaw(mean: Floats, covariance: Floats, heading_rad: float, sigma_rad: float) -> None:
    """Take the heading sensor's yaw where the filter's contradicts it.

    Fixes that jump sideways turn the EKF's yaw (a jump of 2.4 m by some degrees), and in isolation nothing would
    correct it. The heading sensor knows nothing of fixes. Where fixes are only lost, the filter knows yaw better than
    a sensor that may be off by its bias.
    """
    if abs(wrap_angle(mean[2] - heading_rad)) > _YAW_SIGMAS * sigma_rad:
        mean[2] = heading_rad
        covariance[2, 2] = sigma_rad * sigma_rad


@kernel
def _rejoin(
    row: Ints,
    defence: Ints,
    detector: Ints,
    alarm: Flags,
    table: NoiseTable,
    step_s: float,
    hold_s: float,
    rejoin_s: float,
    outage_s: float,
    fix_age_s: Floats,
    mean: Floats,
    covariance: Floats,
    isolated: Flags,
    quiet_s: Floats,
    consistent_s: Floats,
    isolated_way_m: Floats,
    vehicle: Ints,
    fix_m: Floats,
    fix_valid: Flags,
    residual_m: Floats,
    residual_valid: Flags,
    profile: Ints,
) -> None:
    for i in range(len(row)):
        r = row[i]
        d = defence[i]
        q = profile[vehicle[r]]
        lost = fix_age_s[r] > max(outage_s, _OUTAGE_PERIODS * table.gnss_period_s[q])
        quiet_s[r, d] = 0.0 if alarm[r, detector[d]] or lost else quiet_s[r, d] + step_s
        if lost:
            consistent_s[r, d] = 0.0
        if not (fix_valid[r] and residual_valid[r]):
            continue
        m = mean[r, d]
        P = covariance[r, d]
        ux = cos(m[2])
        uy = sin(m[2])
        along = (fix_m[r, 0] - m[0]) * ux + (fix_m[r, 1] - m[1]) * uy
        drift = (table.odometer_scale[q] * isolated_way_m[r, d]) ** 2
        variance = P[0, 0] * ux * ux + 2.0 * P[0, 1] * ux * uy + P[1, 1] * uy * uy
        variance += drift + table.gnss_white_m[q] ** 2 + table.gnss_bias_m[q] ** 2
        agrees = (
            abs(residual_m[r]) <= _GATE_SIGMAS * table.residual_m[q]
            and max(abs(along) - _GATE_ALONG_M, 0.0) <= _GATE_SIGMAS * variance**0.5
        )
        consistent_s[r, d] = consistent_s[r, d] + max(table.gnss_period_s[q], step_s) if agrees else 0.0
        # Half a step of tolerance: sums of steps do not meet round figures exactly.
        if quiet_s[r, d] < hold_s - 0.5 * step_s or consistent_s[r, d] < rejoin_s - 0.5 * step_s:
            continue
        isolated[r, d] = False
        # GNSS may now move the estimate along the lane by what was found, and its slow error is as unknown as at start.
        widened = drift + along * along
        P[0, 0] += widened * ux * ux
        P[0, 1] += widened * ux * uy
        P[1, 0] = P[0, 1]
        P[1, 1] += widened * uy * uy
        bias = table.gnss_bias_m[q] ** 2
        m[3] = 0.0
        m[4] = 0.0
        for a in range(5):
            for b in range(5):
                if a != b and (a > 1 or b > 1):
                    P[a, b] = 0.0
        P[3, 3] = bias
        P[4, 4] = bias

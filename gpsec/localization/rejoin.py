"""Whether fixes agree with a filter that is isolated, and how it takes GNSS back."""

from functools import cache
from math import cos, sin
from typing import NamedTuple

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.filters.noise import FilterNoise
from gpsec.localization.family import BranchLoop, Filter
from gpsec.localization.state import TRUSTS, Branches, Cells, Defences
from gpsec.types.tracks import SAMPLE_S, Tracks

# A fix agrees with the estimate within this many standard deviations …
GATE_SIGMAS = 3.0
# … plus this much along the lane, which an attack may have put into the estimate before it was seen.
GATE_ALONG_M = 1.0


class SwitchSettings(NamedTuple):
    """When GNSS is given up and taken back.

    Attributes:
        hold_s: isolation lasts at least this long after the last alarm.
        rejoin_s: fixes must have agreed for this long.
        outage_s: without a fix for this long, GNSS counts as lost.
        rollback_s: responses that go back restart from at least this long ago.
    """

    hold_s: float = 2.0
    rejoin_s: float = 1.0
    outage_s: float = 0.5
    rollback_s: float = 6.0


class SwitchRules(NamedTuple):
    """The settings as kernels read them.

    Attributes:
        step_s: length of a step.
        hold_s, rejoin_s: see `SwitchSettings`.
        lost_after_s: (P,) time without a fix after which GNSS counts as lost, for each profile.
    """

    step_s: float
    hold_s: float
    rejoin_s: float
    lost_after_s: Floats


@inline
def along(mean: Floats, x_m: float, y_m: float) -> tuple[float, float, float]:
    """Return the direction of the estimate's yaw, and how far along it a fix lies ahead of the estimate."""
    ux = cos(mean[2])
    uy = sin(mean[2])
    return ux, uy, (x_m - mean[0]) * ux + (y_m - mean[1]) * uy


@cache
def judging(filter_: Filter) -> BranchLoop:
    """Return the kernel that compares fixes with isolated branches, and says which defences take GNSS back."""
    drift = filter_.drift

    @inline
    def is_near(
        mean: Floats, P: Floats, noise: FilterNoise[Floats], profile: int, way_m: float, x_m: float, y_m: float
    ) -> bool:
        ux, uy, ahead_m = along(mean, x_m, y_m)
        variance = P[0, 0] * ux * ux + 2.0 * P[0, 1] * ux * uy + P[1, 1] * uy * uy
        variance += drift(noise, profile, way_m) + noise.gnss_white_m[profile] ** 2 + noise.gnss_bias_m[profile] ** 2
        return bool(max(abs(ahead_m) - GATE_ALONG_M, 0.0) <= GATE_SIGMAS * variance**0.5)

    @kernel
    def judge(
        rows: Ints,
        branches: Branches,
        cells: Cells,
        defences: Defences,
        tracks: Tracks,
        profile: Ints,
        noise: FilterNoise[Floats],
        rules: SwitchRules,
    ) -> None:
        step_s = rules.step_s
        for row in rows:
            track = branches.track[row]
            q = profile[tracks.vehicle[track]]
            lost = cells.lost[track]
            comparable = tracks.residual_valid[track]
            branches.entered[row] = False
            if lost:
                branches.consistent_s[row] = 0.0
            if comparable:
                agrees = abs(tracks.residual_m[track]) <= GATE_SIGMAS * noise.residual_m[q] and is_near(
                    branches.mean[row],
                    branches.covariance[row],
                    noise,
                    q,
                    branches.isolated_way_m[row],
                    tracks.paired_m[track, 0],
                    tracks.paired_m[track, 1],
                )
                agreed_s = branches.consistent_s[row] + max(noise.gnss_period_s[q], SAMPLE_S, step_s)
                branches.consistent_s[row] = agreed_s if agrees else 0.0
            for d in defences.column:
                if cells.branch[track, d] != row:
                    continue
                cells.quiet_s[track, d] = 0.0 if cells.alarm[track, d] or lost else cells.quiet_s[track, d] + step_s
                # Half a step of tolerance: sums of steps do not meet round figures exactly.
                quiet = cells.quiet_s[track, d] >= rules.hold_s - 0.5 * step_s
                if comparable and quiet and branches.consistent_s[row] >= rules.rejoin_s - 0.5 * step_s:
                    cells.response[track, d] = TRUSTS
                    cells.parts[track] = True

    return judge


@cache
def trusting(filter_: Filter) -> BranchLoop:
    """Return the kernel that lets GNSS move estimates along the lane by what was found."""
    drift, trust = filter_.drift, filter_.trust

    @kernel
    def trust_again(rows: Ints, branches: Branches, tracks: Tracks, profile: Ints, noise: FilterNoise[Floats]) -> None:
        for row in rows:
            track = branches.track[row]
            q = profile[tracks.vehicle[track]]
            P = branches.covariance[row]
            ux, uy, ahead_m = along(branches.mean[row], tracks.paired_m[track, 0], tracks.paired_m[track, 1])
            widened = drift(noise, q, branches.isolated_way_m[row]) + ahead_m * ahead_m
            P[0, 0] += widened * ux * ux
            P[0, 1] += widened * ux * uy
            P[1, 0] = P[0, 1]
            P[1, 1] += widened * uy * uy
            trust(branches.mean[row], P, noise, q)

    return trust_again

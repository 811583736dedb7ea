"""What the monitor knows, what it remembers of each track, and what it is handed."""

from typing import NamedTuple

from gpsec.core.arrays import Flags, Floats, Ints
from gpsec.core.tables import blank
from gpsec.detection.channels import Channels
from gpsec.filters.adapting import MOST_VARIANCE
from gpsec.filters.noise import FilterNoise


class MonitorRules(NamedTuple):
    """What the monitor knows and how far it adapts.

    Attributes:
        step_s: length of a step.
        noise: sensor figures of the P profiles.
        gate: (P,) statistic above which the monitor is in alarm, see `gpsec.detection.gate`.
        cap: how many times the data sheet's variances are believed at most.
        learns_below: variances are learnt while the statistic is below this, whatever the gate.
    """

    step_s: float
    noise: FilterNoise[Floats]
    gate: Floats
    cap: float
    learns_below: float


# Where an attacker counts, and where maps are poor: `cap` and `learns_below`.
PRESETS = {"R2": (MOST_VARIANCE, 20.5), "R3": (3.0, 41.0)}


class MonitorState(NamedTuple):
    """M rows.

    Attributes:
        started: (M,) the first fix has come.
        due: (M,) no fix was tested since the last tick of the detection clock.
        mean, covariance: (M, 7), (M, 7, 7) of the filter.
        slow: (M, 2) fast and slow part of the residual (m).
        slow_covariance: (M, 3) their variances with the covariance between them, -1 before the first step.
        lane, course_rad: (M,) lane of the last residual, and heading there.
        sums: (M, 3, 4, 4) evidence.
        sample, there: (M, 4) the whitened channels of this step, and which there are.
        gnss, camera, scale: (M,) logarithm of the learnt factors of the variances of fix and camera, and of the
            statistic.
        statistic: (M,) of the last test.
        alarm: (M,) it is above the gate of the track's profile.
        calm, agreed_s: (M,) samples in alarm that are small, and time in alarm in which all agrees.
        blind_s, fix_age_s: (M,) time since the camera saw a lane, and since the last fix.
        innovation: (M, 2) room for the filter's own.
    """

    started: Flags = blank(False)
    due: Flags = blank(False)
    mean: Floats = blank(0.0, 7)
    covariance: Floats = blank(0.0, 7, 7)
    slow: Floats = blank(0.0, 2)
    slow_covariance: Floats = blank(-1.0, 3)
    lane: Ints = blank(-1)
    course_rad: Floats = blank(0.0)
    sums: Floats = blank(0.0, 3, 4, 4)
    sample: Floats = blank(0.0, 4)
    there: Flags = blank(False, 4)
    gnss: Floats = blank(0.0)
    camera: Floats = blank(0.0)
    scale: Floats = blank(0.0)
    statistic: Floats = blank(0.0)
    alarm: Flags = blank(False)
    calm: Ints = blank(0)
    agreed_s: Floats = blank(0.0)
    blind_s: Floats = blank(0.0)
    fix_age_s: Floats = blank(0.0)
    innovation: Floats = blank(0.0, 2)


class Watched(NamedTuple):
    """One step of the monitor.

    Attributes:
        ticks: the detection clock ticks in it.
        rows: (m,) track rows.
        told: what is said of them.
    """

    ticks: bool
    rows: Ints
    told: Channels


class MonitorInputs(NamedTuple):
    """What the monitor is handed of n samples, beside what `gpsec.detection.logs.ResidualLog` has of them.

    Attributes:
        fix_east_m, fix_north_m, fix_valid: (n,) the fix, and whether there is one.
        heading_rad, yaw_rate_rps: (n,).
        lane: (n,) that of the last residual's camera sample.
        sees_lane: (n,) the camera sees a lane, and the vehicle knows which.
        unmatched: (n,) as in `Tracks`.
    """

    fix_east_m: Floats = blank(0.0)
    fix_north_m: Floats = blank(0.0)
    fix_valid: Flags = blank(False)
    heading_rad: Floats = blank(0.0)
    yaw_rate_rps: Floats = blank(0.0)
    lane: Ints = blank(-1)
    sees_lane: Flags = blank(False)
    unmatched: Flags = blank(False)

"""Solution separation: filters that have not used the newest fixes, against these fixes.

What a filter has absorbed, it does not find in its own innovations. So every `LAG_STEP_S` one of four filters becomes
what the monitor's is, and goes on by odometer and gyro alone; their fixes are up to 3, 6, 9 and 12 s old. The mean of
the last fixes is compared with each one that is at least `LEAST_LAG_S` old. With ν the innovations against it,

    m = Σ λʲ ν / Σ λʲ        S = H P Hᵀ + R · Σ λ²ʲ / (Σ λʲ)²        T = max over the filters of mᵀ S⁻¹ m

Source: solution separation for integrity, R. G. Brown and P. McBurney, NAVIGATION 35(1), 1988; against spoofing of
coupled filters, C. Tanil, S. Khanafseh, M. Joerger and B. Pervan, IEEE TAES 54(1), 2018.
"""

from math import exp
from typing import NamedTuple

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.core.tables import blank
from gpsec.detection.monitor_state import MonitorRules, MonitorState, Watched
from gpsec.detection.standing import move_or_stand
from gpsec.filters.learning import LEARNING_STATES
from gpsec.types.tracks import Tracks
from gpsec.types.vehicles import Measurements, Vehicles

LAGS = 4
LAG_STEP_S, LEAST_LAG_S = 3.0, 2.0
# λ of the mean of fixes, in samples: of about the last 0.7 s.
_DECAY = 0.85
# A fix that is e³ times likelier without the mean begins a new one.
_CONTRADICTS = -3.0


class LagState(NamedTuple):
    """M rows.

    Attributes:
        mean, covariance: (M, 4, 7), (M, 4, 7, 7) of the filters.
        age_s: (M, 4) time since each became the monitor's, -1 before.
        sums: (M, 4, 4) of their innovations east and north, Σ λʲ and Σ λ²ʲ.
        oldest: (M,) number of the filter that is replaced next.
        since_s: (M,) time since one was replaced.
    """

    mean: Floats = blank(0.0, LAGS, 7)
    covariance: Floats = blank(0.0, LAGS, 7, 7)
    age_s: Floats = blank(-1.0, LAGS)
    sums: Floats = blank(0.0, LAGS, 4)
    oldest: Ints = blank(0)
    since_s: Floats = blank(LAG_STEP_S)


@inline
def _compare(mean: Floats, P: Floats, sums: Floats, x_m: float, y_m: float, white_variance: float) -> float:
    """Take a fix into the mean, and return mᵀ S⁻¹ m."""
    east, north = x_m - mean[0] - mean[3], y_m - mean[1] - mean[4]
    if sums[2] > 0.0:
        m_e, m_n = sums[0] / sums[2], sums[1] / sums[2]
        gain = (m_e * east + m_n * north - 0.5 * (m_e * m_e + m_n * m_n)) / white_variance
        if gain < _CONTRADICTS:
            sums[:] = 0.0
    sums[0] = _DECAY * sums[0] + east
    sums[1] = _DECAY * sums[1] + north
    sums[2] = _DECAY * sums[2] + 1.0
    sums[3] = _DECAY * _DECAY * sums[3] + 1.0
    m_e, m_n = sums[0] / sums[2], sums[1] / sums[2]
    white = white_variance * sums[3] / (sums[2] * sums[2])
    s_ee = P[0, 0] + 2.0 * P[0, 3] + P[3, 3] + white
    s_nn = P[1, 1] + 2.0 * P[1, 4] + P[4, 4] + white
    s_en = P[0, 1] + P[0, 4] + P[1, 3] + P[3, 4]
    return float((s_nn * m_e * m_e - 2.0 * s_en * m_e * m_n + s_ee * m_n * m_n) / (s_ee * s_nn - s_en * s_en))


@kernel
def look_back(
    part: Ints,
    watched: Watched,
    rules: MonitorRules,
    tracks: Tracks,
    vehicles: Vehicles,
    seen: Measurements,
    monitor: MonitorState,
    state: LagState,
) -> None:
    """Take one step of the tracks at positions `part` of the rows that are watched, after the monitor has."""
    step_s, noise = rules.step_s, rules.noise
    for i in part:
        row = watched.rows[i]
        v = tracks.vehicle[row]
        p = vehicles.profile[v]
        watched.told.separation[i] = 0.0
        if not monitor.started[row]:
            continue
        statistic = 0.0
        white = noise.gnss_white_m[p] ** 2 * exp(monitor.gnss[row])
        for lag in range(LAGS):
            if state.age_s[row, lag] < 0.0:
                continue
            state.age_s[row, lag] += step_s
            mean, P = state.mean[row, lag], state.covariance[row, lag]
            move_or_stand(mean, P, noise, p, seen.speed_mps[v], seen.yaw_rate_rps[v], step_s)
            if watched.told.tested[i]:
                found = _compare(mean, P, state.sums[row, lag], tracks.fix_m[row, 0], tracks.fix_m[row, 1], white)
                # Half a step of tolerance: sums of steps do not meet round figures exactly.
                if state.age_s[row, lag] > LEAST_LAG_S - 0.5 * step_s:
                    statistic = max(statistic, found)
        if watched.told.tested[i]:
            watched.told.separation[i] = statistic / exp(monitor.scale[row])
        state.since_s[row] += step_s
        if state.since_s[row] > LAG_STEP_S - 0.5 * step_s and not monitor.alarm[row]:
            oldest = state.oldest[row]
            for a in range(LEARNING_STATES):
                state.mean[row, oldest, a] = monitor.mean[row, a]
                for b in range(LEARNING_STATES):
                    state.covariance[row, oldest, a, b] = monitor.covariance[row, a, b]
            for a in range(4):
                state.sums[row, oldest, a] = 0.0
            state.age_s[row, oldest] = 0.0
            state.oldest[row] = (oldest + 1) % LAGS
            state.since_s[row] = 0.0

"""The monitor: one filter a track that trusts GNSS until its own alarm, and what it whitens for detectors.

It is an EKF that learns odometer scale and gyro bias (`gpsec.filters.learning`), and beside it the slow part of the
residual, which the filter never sees: a filter that knew the camera would follow an attacker who moves slowly enough.
What the fix and the residual say beyond that is whitened, with variances that are learnt for each vehicle, and tested
over four time scales (`evidence`). Its own alarm, at the strictest rate (`gate`), keeps spoofed fixes out of it; so one
monitor serves all detectors, whatever their thresholds. Isolation is the response's matter.
"""

from math import cos, exp, log, sin, sqrt
from typing import Any

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.core.tables import Table
from gpsec.core.threads import Threads
from gpsec.detection.channels import Channels, first_channels
from gpsec.detection.evidence import (
    ACROSS_CHANNEL,
    ALONG_CHANNEL,
    CAMERA_CHANNEL,
    CHANNEL_COUNT,
    UNMATCHED_CHANNEL,
    drop_channel,
    is_contradicted,
    weigh,
)
from gpsec.detection.looking_back import LagState, look_back
from gpsec.detection.monitor_state import MonitorRules, MonitorState, Watched
from gpsec.detection.pairing import DetectionClock, Pending
from gpsec.detection.slow_part import (
    FAST_PART,
    SLOW_PART,
    age_parts,
    correct_parts,
    cut_camera,
    variance_of_parts,
    widen_slow_part,
)
from gpsec.detection.standing import move_or_stand
from gpsec.filters.adapting import MEAN_CUT_SQUARE, cut_square, learning_gain, learnt
from gpsec.filters.learning import start_learning, update_learning
from gpsec.types.tracks import SAMPLE_S, Tracks
from gpsec.types.vehicles import Measurements, Vehicles

# Above this one, evidence that a sample contradicts is dropped; no threshold of `joint` is lower.
_SUSPECT = 20.0
# The statistic that one honest sample in ten is above, where all variances are as the data sheet says.
_TENTH = 8.6
# In alarm, so many samples whose squares sum to less than `_CALM` end the evidence.
_CALM_SAMPLES, _CALM = 5, 9.0
# A camera that has seen no lane for this long is blind; beyond the limit, fixes are used again all the same.
_BLIND_AFTER_S, _BLIND_LIMIT_S = 0.35, 10.0
# The monitor takes GNSS back where the camera agrees within this many standard deviations, and fixes within some
# metres and three of theirs, for this long.
_REJOIN_SIGMAS, _REJOIN_M, _REJOIN_S = 2.0, 1.0, 1.0
# A fix that no lane matches is at least so far from where the camera sees the vehicle; it counts for no more than this.
_UNMATCHED_M, _UNMATCHED_SIGMAS = 1.6, 3.0
# The scale of the statistic is not believed to be above 2.
_MOST_SCALE = 2.0


@inline
def whiten_fix(
    mean: Floats, P: Floats, x_m: float, y_m: float, white_variance: float, sample: Floats
) -> tuple[float, float]:
    """Set the innovation along, and across given that along, in standard deviations (Cholesky).

    ν = fix - H x, S = H P Hᵀ + R, both turned into the vehicle's frame. Returns ν², and the trace of S.
    """
    east, north = x_m - mean[0] - mean[3], y_m - mean[1] - mean[4]
    s_ee = P[0, 0] + 2.0 * P[0, 3] + P[3, 3] + white_variance
    s_nn = P[1, 1] + 2.0 * P[1, 4] + P[4, 4] + white_variance
    s_en = P[0, 1] + P[0, 4] + P[1, 3] + P[3, 4]
    c, s = cos(mean[2]), sin(mean[2])
    along, across = c * east + s * north, c * north - s * east
    s_aa = c * c * s_ee + 2.0 * c * s * s_en + s * s * s_nn
    s_cc = s * s * s_ee - 2.0 * c * s * s_en + c * c * s_nn
    s_ac = c * s * (s_nn - s_ee) + (c * c - s * s) * s_en
    sample[ALONG_CHANNEL] = along / sqrt(s_aa)
    sample[ACROSS_CHANNEL] = (across - s_ac / s_aa * along) / sqrt(max(s_cc - s_ac * s_ac / s_aa, 1e-12))
    return east * east + north * north, s_aa + s_cc


@inline
def _widen(P: Floats, variance: float) -> None:
    P[0, 0] += variance
    P[1, 1] += variance


@kernel
def watch(
    part: Ints,
    watched: Watched,
    rules: MonitorRules,
    pending: Pending,
    tracks: Tracks,
    vehicles: Vehicles,
    seen: Measurements,
    state: MonitorState,
) -> None:
    """Take one step of the tracks at positions `part` of the rows that are watched, and say what was found."""
    told, step_s, noise = watched.told, rules.step_s, rules.noise
    for i in part:
        row = watched.rows[i]
        v = tracks.vehicle[row]
        p = vehicles.profile[v]
        mean, P = state.mean[row], state.covariance[row]
        w, there = state.sample[row], state.there[row]
        told.tested[i] = False
        told.joint[i], told.innovation[i] = 0.0, 0.0
        for c in range(CHANNEL_COUNT):
            w[c] = 0.0
            there[c] = False
        x, y = tracks.fix_m[row, 0], tracks.fix_m[row, 1]
        state.due[row] = state.due[row] or watched.ticks
        state.fix_age_s[row] = 0.0 if tracks.fix_valid[row] else state.fix_age_s[row] + step_s
        state.blind_s[row] = 0.0 if seen.camera_valid[v] and tracks.lane_known[row] else state.blind_s[row] + step_s
        blind = _BLIND_AFTER_S < state.blind_s[row] < _BLIND_LIMIT_S
        tested = tracks.fix_valid[row] and state.due[row]
        white = noise.gnss_white_m[p] ** 2 * exp(state.gnss[row])
        camera_white, share, total, distance, spread = 0.0, 0.0, 1.0, 0.0, 0.0
        if not state.started[row]:
            if tracks.fix_valid[row]:
                start_learning(mean, P, noise, p, x, y, seen.heading_rad[v])
                state.started[row] = True
            tested = False
        else:
            speed, rate = seen.speed_mps[v], seen.yaw_rate_rps[v]
            move_or_stand(mean, P, noise, p, speed, rate, step_s)
            level, covariance = state.slow[row], state.slow_covariance[row]
            age_parts(level, covariance, noise, p, step_s)
            if tested:
                state.due[row] = False
                distance, spread = whiten_fix(mean, P, x, y, white, w)
                there[ALONG_CHANNEL] = there[ACROSS_CHANNEL] = True
            if tracks.residual_valid[row]:
                stated = pending.sigma_m[row] ** 2 - noise.camera_bias_m[p] ** 2 - noise.camera_mount_m[p] ** 2
                camera_white = max(stated, noise.camera_white_m[p] ** 2) * exp(state.camera[row])
                heading = seen.heading_rad[v]
                another = pending.lane[row] != state.lane[row]
                turned = sin(heading - state.course_rad[row]) if state.lane[row] >= 0 else 0.0
                widen_slow_part(covariance, noise, p, another, turned)
                state.lane[row], state.course_rad[row] = pending.lane[row], heading
                total = variance_of_parts(covariance) + camera_white + white
                share = camera_white / total
                w[CAMERA_CHANNEL] = cut_camera(
                    (tracks.residual_m[row] - level[FAST_PART] - level[SLOW_PART]) / sqrt(total)
                )
                there[CAMERA_CHANNEL] = True
                drop_channel(state.sums[row], UNMATCHED_CHANNEL)
            elif tested and tracks.unmatched[row]:
                total = variance_of_parts(covariance) + noise.camera_white_m[p] ** 2 * exp(state.camera[row]) + white
                w[UNMATCHED_CHANNEL] = min(_UNMATCHED_M / sqrt(total), _UNMATCHED_SIGMAS)
                there[UNMATCHED_CHANNEL] = True
        sums, before = state.sums[row], state.alarm[row]
        scale = exp(state.scale[row])
        statistic = 0.0
        if there[ALONG_CHANNEL] or there[CAMERA_CHANNEL]:
            if before:
                small = w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3] < _CALM
                state.calm[row] = state.calm[row] + 1 if small else 0
            if state.statistic[row] > _SUSPECT:
                calm = before and state.calm[row] >= _CALM_SAMPLES
                if calm or is_contradicted(sums, w, there):
                    sums[:] = 0.0
            joint, innovation = weigh(sums, w, there, blind)
            statistic = joint / scale
            if tested:
                told.tested[i] = True
                told.joint[i], told.innovation[i] = statistic, innovation / scale
            alarm = statistic > rules.gate[p]
            if alarm and not before:
                state.calm[row] = 0
                state.agreed_s[row] = 0.0
            if alarm and tested:
                reach = _REJOIN_M + 3.0 * sqrt(spread)
                agrees = there[CAMERA_CHANNEL] and abs(w[CAMERA_CHANNEL]) < _REJOIN_SIGMAS and distance < reach * reach
                state.agreed_s[row] = state.agreed_s[row] + max(SAMPLE_S, noise.gnss_period_s[p]) if agrees else 0.0
                if state.agreed_s[row] > _REJOIN_S - 0.5 * step_s:
                    sums[:] = 0.0
                    alarm = False
            if before and not alarm and tested:
                # What was absorbed before the alarm, or gone wrong in it, is as far off as the fix is now.
                _widen(P, distance)
            state.alarm[row], state.statistic[row] = alarm, statistic
        told.along[i], told.across[i], told.camera[i] = w[ALONG_CHANNEL], w[ACROSS_CHANNEL], w[CAMERA_CHANNEL]
        told.blind[i], told.fix_age_s[i] = blind, state.fix_age_s[row]
        if state.alarm[row] or not (there[ALONG_CHANNEL] or there[CAMERA_CHANNEL]):
            continue
        if statistic < rules.learns_below and not blind:
            gain = learning_gain(max(SAMPLE_S, step_s, noise.gnss_period_s[p]))
            if tested:
                excess = cut_square(w[ALONG_CHANNEL]) + cut_square(w[ACROSS_CHANNEL]) - 2.0 * MEAN_CUT_SQUARE
                state.gnss[row] = learnt(state.gnss[row], gain, excess, rules.cap)
                often = 1.0 if statistic > _TENTH else 0.0
                state.scale[row] = min(max(state.scale[row] + 0.01 * (often - 0.1), 0.0), log(_MOST_SCALE))
            if there[CAMERA_CHANNEL]:
                excess = cut_square(w[CAMERA_CHANNEL]) - MEAN_CUT_SQUARE
                state.camera[row] = learnt(state.camera[row], gain * share, excess, rules.cap)
        if tested and not blind:
            update_learning(mean, P, state.innovation[row], x, y, sqrt(white))
        if there[CAMERA_CHANNEL]:
            correct_parts(state.slow[row], state.slow_covariance[row], noise, p, w[CAMERA_CHANNEL] * sqrt(total), total)


class Monitor:
    """The monitor of all tracks.

    Attributes:
        tables: what it remembers, and the filters that it looks back with, if it does.
    """

    def __init__(self, rules: MonitorRules, looks_back: bool = False) -> None:
        self._rules = rules
        self._clock = DetectionClock(rules.step_s)
        self._told = Table(Channels)
        self._memory = Table(MonitorState)
        self._lags = Table(LagState) if looks_back else None
        self.tables: list[Table[Any]] = [self._memory, *([self._lags] if self._lags is not None else [])]

    @property
    def now(self) -> MonitorState:
        """What it remembers of every track."""
        return self._memory.now

    def update(
        self,
        step: int,
        pending: Pending,
        rows: Ints,
        tracks: Tracks,
        vehicles: Vehicles,
        seen: Measurements,
        threads: Threads,
    ) -> Channels:
        """Take step number `step` (from 0) of the (m,) track rows `rows`; return what is to be said of them.

        It comes after the residuals of the step, and is written over in the next one.
        """
        watched = Watched(self._clock.ticks(step), rows, first_channels(self._told, len(rows)))
        positions = np.arange(len(rows), dtype=np.int32)
        threads.run(watch, positions, watched, self._rules, pending, tracks, vehicles, seen, self.now)
        if self._lags is not None:
            moved = tracks, vehicles, seen, self.now
            threads.run(look_back, positions, watched, self._rules, *moved, self._lags.now)
        return watched.told

"""The monitor of one track: an EKF from filterpy, and all samples since evidence was last dropped."""

from collections import deque
from dataclasses import dataclass
from math import exp, log, sin, sqrt

import numpy as np

from gpsec.detection.pairing import DetectionClock
from gpsec.filters.noise import FilterNoise
from gpsec.reference.looking_back import TrackLags
from gpsec.reference.monitor_ekf import MonitorEkf
from gpsec.reference.sight import Sight, Whitened
from gpsec.types.tracks import SAMPLE_S

_DECAYS = (0.0, 0.6, 0.85, 0.95)
# Older samples weigh less than 1e-13.
_SAMPLES = 600
_SUSPECT, _TENTH = 20.0, 8.6
_CUT, _CUT_MEAN = 6.0, 0.9384


@dataclass(frozen=True)
class MonitorSettings:
    """What a track's monitor knows; see `gpsec.detection.monitor.MonitorRules`."""

    noise: FilterNoise[float]
    step_s: float
    gate: float
    cap: float
    learns_below: float

    @property
    def sample_s(self) -> float:
        """Time that a tested fix stands for."""
        return max(SAMPLE_S, self.step_s, self.noise.gnss_period_s)


class Evidence:
    """Whitened samples of four channels since evidence was last dropped."""

    def __init__(self) -> None:
        self.drop()

    def drop(self) -> None:
        """Forget all samples."""
        self._long: list[deque[float]] = [deque(maxlen=_SAMPLES) for _ in range(4)]
        self._last: list[float | None] = [None] * 4

    def drop_channel(self, channel: int) -> None:
        """Forget the samples of one channel."""
        self._long[channel].clear()
        self._last[channel] = None

    def take(self, samples: list[float | None], alone: bool) -> None:
        """Take the samples of a step; those that stand `alone` are not kept."""
        for channel, sample in enumerate(samples):
            if sample is not None:
                self._last[channel] = sample
                if not alone:
                    self._long[channel].append(sample)

    def statistics(self, samples: list[float | None], alone: bool) -> tuple[float, float]:
        """Return the statistics of all channels, and of the innovations, behind the samples just taken."""
        now = [0.0 if sample is None else sample**2 for sample in samples]
        scales = [now] if alone else [now, *(self._ratios(decay) for decay in _DECAYS[1:])]
        return max(sum(one) for one in scales), max(sum(one[:2]) for one in scales)

    def contradicted_by(self, samples: list[float | None]) -> bool:
        """Return whether samples are e³ times likelier without the mean that has the most evidence."""
        last = [0.0 if sample is None else sample**2 for sample in self._last]
        totals = [sum(last), *(sum(self._ratios(decay)) for decay in _DECAYS[1:])]
        best = int(np.argmax(totals))
        gain = 0.0
        for channel, sample in enumerate(samples):
            mean = self._mean(channel, best)
            if sample is not None and mean is not None:
                gain += mean * sample - mean**2 / 2.0
        return gain < -3.0

    def _ratios(self, decay: float) -> list[float]:
        ratios = []
        for samples in self._long:
            weights = decay ** np.arange(len(samples))[::-1]
            ratios.append(float((weights @ samples) ** 2 / (weights @ weights)) if samples else 0.0)
        return ratios

    def _mean(self, channel: int, scale: int) -> float | None:
        if scale == 0:
            return self._last[channel]
        samples = self._long[channel]
        weights = _DECAYS[scale] ** np.arange(len(samples))[::-1]
        return float(weights @ samples / weights.sum()) if samples else None


class SlowPart:
    """Fast and slow part of the residual: a Kalman filter of two processes; see `gpsec.detection.slow_part`."""

    def __init__(self, noise: FilterNoise[float]) -> None:
        self._noise = noise
        slow = noise.camera_mount_m**2 + noise.gnss_bias_m**2
        self._stationary = np.diag([noise.camera_bias_m**2, slow])
        rate = noise.camera_mount_m**2 / 20.0 + noise.gnss_bias_m**2 / max(noise.gnss_bias_tau_s, 20.0)
        self._rate = np.array([1.0 / noise.camera_bias_tau_s, rate / slow if slow > 0.0 else 0.0])
        self._level = np.zeros(2)
        self._covariance = -np.ones((2, 2))
        self._begun = False
        self._lane: int | None = None
        self._course = 0.0

    @property
    def all(self) -> list[float]:
        """Levels, variances and covariance as `MonitorState` has them."""
        P = self._covariance
        return [*self._level, P[0, 0], P[0, 1], P[1, 1]]

    @property
    def level(self) -> float:
        """What both leave in a residual."""
        return float(self._level.sum())

    @property
    def variance(self) -> float:
        """That of the level."""
        return float(np.sum(self._covariance))

    def age(self, step_s: float) -> None:
        """Take a step without a residual."""
        if not self._begun:
            self._covariance, self._begun = self._stationary.copy(), True
            return
        F = np.diag(np.exp(-step_s * self._rate))
        self._level = F @ self._level
        self._covariance = F @ self._covariance @ F.T + self._stationary @ (np.eye(2) - F @ F.T)

    def come_to(self, lane: int, course_rad: float) -> float:
        """Return the variance on a lane."""
        if lane != self._lane:
            self._covariance[1, 1] += 0.07**2
        if self._lane is not None:
            self._covariance[1, 1] += self._noise.gnss_bias_m**2 * sin(course_rad - self._course) ** 2
        self._lane, self._course = lane, course_rad
        return self.variance

    def follow(self, innovation_m: float, total: float) -> None:
        """Correct by what the level leaves of a residual, of the variance `total`."""
        H = np.ones((1, 2))
        PHt = self._covariance @ H.T
        bound = 3.5 * np.sqrt(np.diag(self._stationary))
        self._level = np.clip(self._level + PHt[:, 0] / total * innovation_m, -bound, bound)
        self._covariance = self._covariance - PHt @ PHt.T / total


class TrackMonitor:
    """The monitor of one track; see `gpsec.detection.monitor`."""

    def __init__(self, settings: MonitorSettings) -> None:
        self._is = settings
        self._clock = DetectionClock(settings.step_s)
        self._due = False
        self.ekf: MonitorEkf | None = None
        self.slow = SlowPart(settings.noise)
        self.lags = TrackLags(settings.step_s)
        self._evidence = Evidence()
        self._gnss = self._camera = self._scale = 0.0
        self._statistic = 0.0
        self.alarm = False
        self._calm = 0
        self._agreed_s = self._blind_s = self._fix_age_s = 0.0

    def step(self, number: int, sight: Sight, residual_m: float | None, lane: int) -> Whitened:
        """Take step `number`; `lane` is that of the camera sample that a residual is of."""
        told = self._watch(number, sight, residual_m, lane)
        if self.ekf is None:
            return told
        white, scale = self._is.noise.gnss_white_m**2 * exp(self._gnss), exp(self._scale)
        statistic = self.lags.step(sight, self.ekf, white, told.tested, self.alarm)
        return told._replace(separation=statistic / scale if told.tested else 0.0)

    def _watch(self, number: int, sight: Sight, residual_m: float | None, lane: int) -> Whitened:
        step_s, noise = self._is.step_s, self._is.noise
        self._due = self._due or self._clock.ticks(number)
        self._fix_age_s = 0.0 if sight.fix_m is not None else self._fix_age_s + step_s
        self._blind_s = 0.0 if sight.lane_offset_m is not None else self._blind_s + step_s
        blind = 0.35 < self._blind_s < 10.0
        if self.ekf is None:
            if sight.fix_m is not None:
                self.ekf = MonitorEkf.at_first_fix(noise, sight.fix_m, sight.heading_rad)  # type: ignore[assignment]
            return Whitened(blind=blind, fix_age_s=self._fix_age_s)
        self.ekf.move(sight.speed_mps, sight.yaw_rate_rps, step_s)
        self.slow.age(step_s)
        fix_m = sight.fix_m if self._due else None
        white = noise.gnss_white_m**2 * exp(self._gnss)
        samples: list[float | None] = [None] * 4
        innovation, covariance = np.zeros(2), np.zeros((2, 2))
        if fix_m is not None:
            self._due = False
            innovation, covariance = self.ekf.expected(fix_m, white)
            samples[:2] = np.linalg.solve(np.linalg.cholesky(covariance), innovation).tolist()
        share, total = 0.0, 1.0
        if residual_m is not None:
            slow = noise.camera_bias_m**2 + noise.camera_mount_m**2
            camera_white = max(sight.camera_sigma_m**2 - slow, noise.camera_white_m**2) * exp(self._camera)
            total = self.slow.come_to(lane, sight.heading_rad) + camera_white + white
            samples[2] = float(np.clip((residual_m - self.slow.level) / sqrt(total), -3.0, 3.0))
            self._evidence.drop_channel(3)
            share = camera_white / total
        elif sight.unmatched and fix_m is not None:
            total = self.slow.variance + noise.camera_white_m**2 * exp(self._camera) + white
            samples[3] = min(1.6 / sqrt(total), 3.0)
        along, across, camera, _ = (sample or 0.0 for sample in samples)
        told = Whitened(False, along, across, camera, blind, self._fix_age_s)
        if samples == [None] * 4:
            return told
        joint, pair = self._test(samples, blind)
        before, scale = self.alarm, exp(self._scale)
        self._statistic = joint / scale
        self.alarm = self._statistic > self._is.gate
        if self.alarm and not before:
            self._calm, self._agreed_s = 0, 0.0
        distance = float(innovation @ innovation)
        if self.alarm and fix_m is not None:
            near = distance < (1.0 + 3.0 * sqrt(float(np.trace(covariance)))) ** 2
            agrees = near and samples[2] is not None and abs(samples[2]) < 2.0
            self._agreed_s = self._agreed_s + max(SAMPLE_S, noise.gnss_period_s) if agrees else 0.0
            if self._agreed_s > 1.0 - step_s / 2.0:
                self._evidence.drop()
                self.alarm = False
        if before and not self.alarm and fix_m is not None:
            self.ekf.widen(distance)
        if fix_m is not None:
            told = told._replace(tested=True, joint=self._statistic, innovation=pair / scale)
        if not self.alarm:
            self._learn(samples, share, blind)
            if fix_m is not None and not blind:
                self.ekf.correct(fix_m, white)
            if samples[2] is not None:
                self.slow.follow(samples[2] * sqrt(total), total)
        return told

    @property
    def learnt(self) -> list[float]:
        """Logarithms of the learnt factors of the variances of fix and camera, and of the statistic."""
        return [self._gnss, self._camera, self._scale]

    def _test(self, samples: list[float | None], blind: bool) -> tuple[float, float]:
        """Take samples into the evidence, or drop it for them; return both statistics, not scaled."""
        if self.alarm:
            small = sum(sample**2 for sample in samples if sample is not None) < 9.0
            self._calm = self._calm + 1 if small else 0
        calm = self.alarm and self._calm >= 5
        if self._statistic > _SUSPECT and (calm or self._evidence.contradicted_by(samples)):
            self._evidence.drop()
        self._evidence.take(samples, blind)
        return self._evidence.statistics(samples, blind)

    def _learn(self, samples: list[float | None], share: float, blind: bool) -> None:
        """Learn how noisy fixes and camera are, and how large the statistic is."""
        if blind or self._statistic >= self._is.learns_below:
            return
        low, high = log(0.7), log(self._is.cap)
        gain = self._is.sample_s / 20.0 / 2.0
        along, across, camera, _ = samples
        if along is not None and across is not None:
            excess = min(along**2, _CUT) + min(across**2, _CUT) - 2.0 * _CUT_MEAN
            self._gnss = float(np.clip(self._gnss + gain * excess, low, high))
            often = float(self._statistic > _TENTH)
            self._scale = float(np.clip(self._scale + 0.01 * (often - 0.1), 0.0, log(2.0)))
        if camera is not None:
            excess = min(camera**2, _CUT) - _CUT_MEAN
            self._camera = float(np.clip(self._camera + gain * share * excess, low, high))

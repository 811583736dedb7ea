"""The detectors for one track: plain objects that share nothing but learned values with the kernels."""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from math import exp, inf, sqrt
from typing import cast

import numpy as np

from gpsec.core.errors import GpsecError, nearest
from gpsec.detection.alarm import GAP_S, HOLD_S
from gpsec.detection.base import Detector, LabelledDetector
from gpsec.detection.bounds import Never, Oracle
from gpsec.detection.chi_square import ChiSquare
from gpsec.detection.cusum import Cusum
from gpsec.detection.forecast import CLIP, DELAY, Forecaster
from gpsec.detection.isolation_forest import WINDOW, IsolationForest
from gpsec.detection.lstm import DECAYS, Lstm
from gpsec.detection.lstm_cusum import LstmCusum
from gpsec.reference.forest import PlainForest
from gpsec.reference.network import PlainNetwork
from gpsec.reference.sight import Sight


@dataclass(frozen=True)
class Ruling:
    """What a detector says in one step; the statistic is 0 where nothing was scored."""

    statistic: float
    scored: bool
    alarm: bool


@dataclass(frozen=True)
class Scale:
    """What a detector of one sensor profile is set to.

    Attributes:
        profile: index of the profile.
        scale_m: standard deviation of the residual that the profile promises.
        threshold: over which a statistic is an alarm.
        step_s: length of a step.

    """

    profile: int
    scale_m: float
    threshold: float
    step_s: float


class Watch(ABC):
    """One detector of one track: when it scores, and when its alarm begins, is held and ends."""

    def __init__(self, scale: Scale) -> None:
        self.scale = scale
        self.alarm = False
        self._valid_before_s = 0.0
        self._scored_before_s = 0.0
        # Sums of steps do not meet round figures exactly.
        self._late_s = 1e-6 * scale.step_s

    def step(self, sight: Sight, residual_m: float | None, attacked: bool) -> Ruling:
        """Take one step; `attacked` is for the one that is told the truth."""
        self._valid_before_s += self.scale.step_s
        self._scored_before_s += self.scale.step_s
        statistic = None
        z = None if residual_m is None else residual_m / self.scale.scale_m
        if z is not None:
            if self._valid_before_s > GAP_S + self._late_s:
                self.forget()
            statistic = self.score(z, sight, self._valid_before_s)
            self._valid_before_s = 0.0
        if statistic is not None:
            self.alarm = statistic > self.scale.threshold
            self._scored_before_s = 0.0
        elif self._scored_before_s > HOLD_S + self._late_s:
            self.alarm = False
        if z is not None:
            self.learn(z)
        return Ruling(statistic or 0.0, statistic is not None, self.alarm)

    @abstractmethod
    def forget(self) -> None:
        """Begin anew: there was no valid residual for too long."""

    @abstractmethod
    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return the statistic, None in warm-up, for a normalised residual that comes `elapsed_s` after the last."""

    def learn(self, z: float) -> None:  # noqa: B027 - most have nothing to do
        """Take in the normalised residual, once it is decided whether there is an alarm."""


class ChiSquareWatch(Watch):
    """Mean of the last squared normalised residuals."""

    def __init__(self, detector: ChiSquare, scale: Scale) -> None:
        super().__init__(scale)
        self._last: deque[float] = deque(maxlen=detector.window)

    def forget(self) -> None:
        """Empty the window."""
        self._last.clear()

    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return q = (1/n)·Σ z²."""
        self._last.append(z)
        return float(np.mean(np.square(self._last))) if len(self._last) == self._last.maxlen else None


class CusumWatch(Watch):
    """Two-sided CUSUM of the innovations of a scalar Kalman filter that follows the slow part of the residual."""

    def __init__(self, detector: Cusum, scale: Scale) -> None:
        super().__init__(scale)
        self._is = detector
        self._white, self._slow = detector.white[scale.profile], detector.slow[scale.profile]
        self._tau_s = detector.tau_s[scale.profile]
        self._up = self._down = 0.0
        self._level, self._variance = 0.0, self._slow**2
        self._gain = self._innovation = 0.0

    def forget(self) -> None:
        """Begin with the stationary distribution; an alarm that is held goes on until samples end it."""
        self._level, self._variance = 0.0, self._slow**2
        if not self.alarm:
            self._up = self._down = 0.0

    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return the larger of the two sums."""
        phi = exp(-elapsed_s / self._tau_s)
        self._level *= phi
        self._variance = phi**2 * self._variance + (1.0 - phi**2) * self._slow**2
        self._innovation = z - self._level
        S = self._variance + self._white**2
        self._gain = self._variance / S
        e = float(np.clip(self._innovation / sqrt(S), -self._is.clip, self._is.clip))
        up, down = max(0.0, self._up + e - self._is.slack), max(0.0, self._down - e - self._is.slack)
        cap = self.scale.threshold + self._is.margin * self._is.slack
        self._up, self._down = min(up, cap), min(down, cap)
        return max(up, down)

    def learn(self, z: float) -> None:
        """Correct the level, but not with what an alarm makes doubtful."""
        if self.alarm and abs(z) > self._is.plausible * sqrt(self._white**2 + self._slow**2):
            return
        reach = self._is.reach * self._slow
        self._level = float(np.clip(self._level + self._gain * self._innovation, -reach, reach))
        self._variance *= 1.0 - self._gain


class ForestWatch(Watch):
    """Isolation forest on windows of the residual."""

    def __init__(self, forest: PlainForest, scale: Scale) -> None:
        super().__init__(scale)
        self._forest = forest
        self._last: deque[float] = deque(maxlen=WINDOW)

    def forget(self) -> None:
        """Empty the window."""
        self._last.clear()

    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return the anomaly score of the window and its mean, turned so that the mean is not negative."""
        self._last.append(z)
        if len(self._last) < WINDOW:
            return None
        side = -1.0 if sum(self._last) < 0.0 else 1.0
        features = [side * value for value in self._last]
        features.append(sum(features) / WINDOW)
        return self._forest.score(np.clip(features, -1e6, 1e6))


class ForecastWatch(Watch):
    """What both detectors do that ask the LSTM what to expect."""

    def __init__(self, detector: Forecaster, network: PlainNetwork, scale: Scale) -> None:
        super().__init__(scale)
        self._network = network
        self._patience, self._plausible = detector.distrust, detector.plausible
        self.forget()

    def forget(self) -> None:
        """Empty the memory."""
        self._memory = self._network.blank()
        self._waiting = deque([0.0] * DELAY)
        self._prediction = 0.0
        self._distrust = 0

    def expect(self, sight: Sight) -> tuple[float, list[float]]:
        """Return the residual that the network expects, and the variance of its error at each scale."""
        inputs = [
            self._waiting.popleft(),
            float(np.clip(40.0 * sight.curvature_per_m, -4.0, 4.0)),
            min(sight.speed_mps / 20.0, 4.0),
            min(sight.camera_sigma_m / self.scale.scale_m, 4.0),
        ]
        (self._prediction, *log_variances), self._memory = self._network.predict(inputs, self._memory)
        return self._prediction, [exp(value) for value in log_variances]

    def learn(self, z: float) -> None:
        """Let the residual wait, or the prediction where a large residual is not to be believed."""
        if self.alarm:
            self._distrust = self._patience
        doubtful = self._distrust > 0 and abs(z) > max(abs(self._prediction), self._plausible)
        self._waiting.append(float(np.clip(self._prediction if doubtful else z, -CLIP, CLIP)))
        if not self.alarm:
            self._distrust = max(self._distrust - 1, 0)


class LstmWatch(ForecastWatch):
    """Squared error of an LSTM that predicts the residual (Eq 10), at several time scales."""

    def __init__(self, detector: Lstm, network: PlainNetwork, scale: Scale) -> None:
        self._enough = detector.enough
        super().__init__(detector, network, scale)

    def forget(self) -> None:
        """Empty memory and evidence."""
        super().forget()
        self._errors: list[float] = []

    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return the largest (Σ λʲ·e)² / (Σ λ²ʲ · σ²)."""
        prediction, variances = self.expect(sight)
        error = z - prediction
        if self.alarm and self._errors:
            values, means = zip(*(self._at(decay, v) for decay, v in zip(DECAYS, variances, strict=True)), strict=True)
            offset = means[int(np.argmax(values))]
            if (offset * error - 0.5 * offset**2) / variances[0] < -self._enough:
                self._errors.clear()
        self._errors.append(error)
        return max(self._at(decay, v)[0] for decay, v in zip(DECAYS, variances, strict=True))

    def _at(self, decay: float, variance: float) -> tuple[float, float]:
        """Return the statistic and the mean error at one scale."""
        weights = np.power(decay, np.arange(len(self._errors))[::-1])
        total = float(weights @ self._errors)
        return total**2 / float(weights @ weights) / variance, total * (1.0 - decay)


class LstmCusumWatch(ForecastWatch):
    """Two-sided CUSUM of the errors of the LSTM's prediction."""

    def __init__(self, detector: LstmCusum, network: PlainNetwork, scale: Scale) -> None:
        self._is = detector
        self._up = self._down = 0.0
        super().__init__(detector, network, scale)

    def forget(self) -> None:
        """Empty the memory; an alarm that is held goes on until samples end it."""
        super().forget()
        if not self.alarm:
            self._up = self._down = 0.0

    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return the larger of the two sums."""
        prediction, variances = self.expect(sight)
        e = float(np.clip((z - prediction) / sqrt(variances[0]), -self._is.clip, self._is.clip))
        # What lasts is in the variance of the weighted sum once for every pair of samples, what does not only once.
        pairs = (1.0 + DECAYS[-1]) / (1.0 - DECAYS[-1])
        lasting = max(variances[-1] - variances[0], 0.0) / (pairs - 1.0)
        slack = self._is.slack + self._is.reach * sqrt(lasting / variances[0])
        up, down = max(0.0, self._up + e - slack), max(0.0, self._down - e - slack)
        cap = self.scale.threshold + self._is.margin * slack
        self._up, self._down = min(up, cap), min(down, cap)
        return max(up, down)


class NeverWatch(Watch):
    """Scores every residual with 0."""

    def __init__(self, scale: Scale) -> None:
        super().__init__(Scale(scale.profile, scale.scale_m, inf, scale.step_s))

    def forget(self) -> None:
        """Do nothing."""

    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return 0."""
        return 0.0


class OracleWatch(NeverWatch):
    """Is told the truth."""

    def step(self, sight: Sight, residual_m: float | None, attacked: bool) -> Ruling:
        """Be in alarm exactly while the attack is active."""
        return Ruling(float(attacked), True, attacked)


MakeWatch = Callable[[Scale], Watch]


def watch_maker(detector: Detector | LabelledDetector, profiles: int) -> MakeWatch:
    """Return what makes the reference of `detector` for a track.

    Args:
        detector: the batched one, for its parameters and what it learned on each profile.
        profiles: number of sensor profiles.

    Raises:
        GpsecError: there is no reference of that detector.

    """
    if isinstance(detector, ChiSquare):
        return lambda scale: ChiSquareWatch(detector, scale)
    if isinstance(detector, Cusum):
        return lambda scale: CusumWatch(detector, scale)
    if isinstance(detector, IsolationForest):
        forests = [PlainForest(detector.learned[profile]) for profile in range(profiles)]
        return lambda scale: ForestWatch(forests[scale.profile], scale)
    if isinstance(detector, Forecaster):
        networks = [PlainNetwork(detector.learned[profile]) for profile in range(profiles)]
    if isinstance(detector, Lstm):
        return lambda scale: LstmWatch(detector, networks[scale.profile], scale)
    if isinstance(detector, LstmCusum):
        return lambda scale: LstmCusumWatch(detector, networks[scale.profile], scale)
    if isinstance(detector, Never):
        return NeverWatch
    if isinstance(detector, Oracle):
        return OracleWatch
    known = [kind.name for kind in (ChiSquare, Cusum, IsolationForest, Lstm, LstmCusum, Never, Oracle)]
    name = cast("Detector", detector).name
    raise GpsecError(f"the reference engine has no detector '{name}': {nearest(name, known)}")

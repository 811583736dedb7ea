"""The detectors for one track: plain objects that share nothing but learned values with the kernels."""

from collections import deque
from collections.abc import Callable
from math import exp, inf, sqrt
from typing import cast

import numpy as np

from gpsec.core.errors import GpsecError, nearest
from gpsec.detection.base import Detector, LabelledDetector
from gpsec.detection.bounds import Never, Told
from gpsec.detection.chi_square import ChiSquare
from gpsec.detection.cusum import Cusum
from gpsec.detection.forecast import Forecaster
from gpsec.detection.innovation import Innovation
from gpsec.detection.isolation_forest import IsolationForest
from gpsec.detection.joint import Joint
from gpsec.detection.lstm import Lstm
from gpsec.detection.lstm_cusum import LstmCusum
from gpsec.detection.lstm_glr import LstmGlr
from gpsec.detection.separation import Separation
from gpsec.detection.watching import WatchingDetector
from gpsec.reference.detector import Scale, TrackDetector, TrackVerdict, TrackWatching
from gpsec.reference.forecast import PlainNetwork, TrackLstm, TrackLstmCusum, TrackLstmGlr
from gpsec.reference.forest import PlainForest, TrackForest
from gpsec.reference.sight import Sight


class TrackChiSquare(TrackDetector):
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


class TrackCusum(TrackDetector):
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
        """Correct the level, but not by implausible residuals in alarm."""
        if self.alarm and abs(z) > self._is.plausible * sqrt(self._white**2 + self._slow**2):
            return
        reach = self._is.reach * self._slow
        self._level = float(np.clip(self._level + self._gain * self._innovation, -reach, reach))
        self._variance *= 1.0 - self._gain


class TrackNever(TrackDetector):
    """Scores every residual with 0."""

    def __init__(self, scale: Scale) -> None:
        super().__init__(Scale(scale.profile, scale.scale_m, inf, scale.step_s))

    def forget(self) -> None:
        """Do nothing."""

    def score(self, z: float, sight: Sight, elapsed_s: float) -> float | None:
        """Return 0."""
        return 0.0


class TrackTold(TrackNever):
    """Told at once: it reads the label."""

    def step(self, sight: Sight, residual_m: float | None, attacked: bool) -> TrackVerdict:
        """Be in alarm exactly while the attack is active."""
        return TrackVerdict(float(attacked), True, attacked)


MakeDetector = Callable[[Scale], TrackDetector]


def detector_maker(detector: Detector | LabelledDetector, profiles: int) -> MakeDetector:
    """Return a function that makes the reference of `detector` for a track.

    Args:
        detector: the batched one, for its parameters and what it learned on each profile.
        profiles: number of sensor profiles.

    Raises:
        GpsecError: there is no reference of that detector.

    """
    if isinstance(detector, ChiSquare):
        return lambda scale: TrackChiSquare(detector, scale)
    if isinstance(detector, Cusum):
        return lambda scale: TrackCusum(detector, scale)
    if isinstance(detector, IsolationForest):
        forests = [PlainForest(detector.learned[profile]) for profile in range(profiles)]
        return lambda scale: TrackForest(forests[scale.profile], scale)
    if isinstance(detector, Forecaster):
        networks = [PlainNetwork(detector.learned[profile]) for profile in range(profiles)]
    if isinstance(detector, Lstm):
        return lambda scale: TrackLstm(detector, networks[scale.profile], scale)
    if isinstance(detector, LstmGlr):
        return lambda scale: TrackLstmGlr(detector, networks[scale.profile], scale)
    if isinstance(detector, LstmCusum):
        return lambda scale: TrackLstmCusum(detector, networks[scale.profile], scale)
    if isinstance(detector, WatchingDetector):
        statistic = detector.name
        return lambda scale: TrackWatching(statistic, scale)
    if isinstance(detector, Never):
        return TrackNever
    if isinstance(detector, Told):
        return TrackTold
    kinds = (ChiSquare, Cusum, Innovation, IsolationForest, Joint, Lstm, LstmGlr, LstmCusum, Never, Separation, Told)
    known = [kind.name for kind in kinds]
    name = cast("Detector", detector).name
    raise GpsecError(f"the reference engine has no detector '{name}': {nearest(name, known)}")

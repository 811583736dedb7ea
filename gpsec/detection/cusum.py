"""Two-sided CUSUM of the whitened residual."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import exp, sqrt
from typing import ClassVar, NamedTuple, Self, cast

import numpy as np

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import inline, kernel
from gpsec.detection.alarm import Alarms, AlarmState, blank_alarm, decide, gap_before, hold
from gpsec.detection.base import KernelDetector, Observation
from gpsec.detection.learned import Learned, scalars


@dataclass
class CusumState(AlarmState):
    """Attributes beside those of `AlarmState`.

    level: (M,) estimate of the slow part of the normalised residual.
    variance: (M,) of that estimate, relative to its stationary variance.
    up, down: (M,) sums of positive and of negative innovations.
    """

    level: Floats
    variance: Floats
    up: Floats
    down: Floats

    @classmethod
    def empty(cls, capacity: int) -> Self:
        """Return `capacity` rows that have seen nothing."""
        return cls(
            **blank_alarm(capacity),
            level=np.zeros(capacity),
            variance=np.ones(capacity),
            up=np.zeros(capacity),
            down=np.zeros(capacity),
        )


@inline
def innovate(
    z: float, decay: float, white: float, slow: float, level: float, variance: float
) -> tuple[float, float, float, float, float]:
    """Return (predicted level, its relative variance, innovation, its variance, gain) of the scalar Kalman filter.

    The level decays by `decay` since the last sample; `variance` is relative to the stationary slow².
    """
    level = decay * level
    variance = decay * decay * variance + (1.0 - decay * decay)
    spread = slow * slow * variance + white * white
    return level, variance, z - level, spread, slow * slow * variance / spread


class Settings(NamedTuple):
    """The numbers of a `Cusum`; (P,) arrays for P profiles."""

    white: Floats
    slow: Floats
    tau_s: Floats
    slack: float
    clip: float
    reach: float
    plausible: float
    margin: float


@kernel
def _update(
    part: Ints,
    seen: Observation,
    threshold: Floats,
    alarms: Alarms,
    settings: Settings,
    level: Floats,
    variance: Floats,
    up: Floats,
    down: Floats,
) -> None:
    known_s, known, decay = -1.0, -1, 0.0
    for i in part:
        row = seen.rows[i]
        if not seen.valid[i]:
            alarms.since_valid[row] += 1
            hold(alarms, row)
            continue
        p = seen.profile[i]
        white, slow = settings.white[p], settings.slow[p]
        elapsed_s = (alarms.since_valid[row] + 1) * seen.step_s
        if gap_before(alarms, row):
            level[row], variance[row] = 0.0, 1.0
            # An alarm that is held over the gap goes on until ordinary samples end it.
            if not alarms.alarm[row]:
                up[row], down[row] = 0.0, 0.0
        z = seen.residual_m[i] / seen.scale_m[i]
        if elapsed_s != known_s or p != known:  # as a rule, one step has passed
            known_s, known, decay = elapsed_s, p, exp(-elapsed_s / settings.tau_s[p])
        predicted, spread, innovation, innovation_variance, gain = innovate(
            z, decay, white, slow, level[row], variance[row]
        )
        e = min(max(innovation / sqrt(innovation_variance), -settings.clip), settings.clip)
        plus = max(0.0, up[row] + e - settings.slack)
        minus = max(0.0, down[row] - e - settings.slack)
        decide(alarms, row, max(plus, minus), threshold[i])
        cap = threshold[i] + settings.margin * settings.slack
        up[row], down[row] = min(plus, cap), min(minus, cap)
        if alarms.alarm[row] and abs(z) > settings.plausible * sqrt(white * white + slow * slow):
            level[row], variance[row] = predicted, spread
        else:
            bound = settings.reach * slow
            level[row] = min(max(predicted + gain * innovation, -bound), bound)
            variance[row] = (1.0 - gain) * spread


@dataclass(frozen=True)
class Cusum(KernelDetector):
    """Page's cumulative sums of what a filter of the slow GNSS error did not expect.

    The normalised residual is taken as white noise (σ_w) on a first-order Gauss–Markov process (σ_b, τ); a scalar
    Kalman filter follows the latter, and its innovation e in units of its own standard deviation is white with unit
    variance on benign data. With e clipped to ±c,

        S⁺ ← max(0, S⁺ + e - k),   S⁻ ← max(0, S⁻ - e - k),   statistic = max(S⁺, S⁻).

    The estimate is kept within ±reach·σ_b, so that a slow drift cannot take it along for ever; and in alarm the
    filter is only updated by residuals within ±plausible·√(σ_w² + σ_b²), so that it does not learn a spoofed bias,
    but recovers from a false alarm. The sums are capped at threshold + margin·k: an alarm ends at most `margin`
    samples of zero after its cause.

    Source: E. S. Page, "Continuous inspection schemes", Biometrika 41, 1954.

    Attributes:
        white: (P,) σ_w per profile, in units of the promised scale.
        slow: (P,) σ_b, likewise.
        tau_s: (P,) τ.
        slack: k.
        clip: c.
        reach, plausible, margin: see above.
    """

    name: ClassVar[str] = "cusum"
    kernel = _update
    white: tuple[float, ...]
    slow: tuple[float, ...]
    tau_s: tuple[float, ...]
    slack: float = 0.75
    clip: float = 6.0
    reach: float = 3.0
    plausible: float = 2.5
    margin: float = 1.0

    @classmethod
    def from_learned(cls, learned: Sequence[Learned]) -> Self:
        """Return the detector for profiles in the order of `learned`."""
        return cls(white=scalars(learned, "white"), slow=scalars(learned, "slow"), tau_s=scalars(learned, "tau_s"))

    def new_state(self, capacity: int) -> CusumState:
        """Return the detector's arrays for `capacity` rows."""
        return CusumState.empty(capacity)

    @cached_property
    def settings(self) -> Settings:
        """The numbers as the kernel reads them."""
        return Settings(
            np.asarray(self.white),
            np.asarray(self.slow),
            np.asarray(self.tau_s),
            self.slack,
            self.clip,
            self.reach,
            self.plausible,
            self.margin,
        )

    def arguments(self, state: AlarmState) -> tuple[object, ...]:
        """Return what the kernel needs beside the observation."""
        own = cast("CusumState", state)
        return self.settings, own.level, own.variance, own.up, own.down

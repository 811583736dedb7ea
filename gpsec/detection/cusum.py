"""Two-sided CUSUM of the whitened residual."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import exp, sqrt
from typing import ClassVar, NamedTuple, Self

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.kernels import always_inline, inline
from gpsec.core.tables import Table, blank
from gpsec.detection.base import Observation
from gpsec.detection.families import KernelDetector, each_residual
from gpsec.detection.learned import Learned, scalars


class CusumState(NamedTuple):
    """M rows.

    Attributes:
        level: (M,) estimate of the slow part of the normalised residual.
        variance: (M,) of that estimate, relative to its stationary variance.
        up, down: (M,) sums of positive and of negative innovations.
    """

    level: Floats = blank(0.0)
    variance: Floats = blank(1.0)
    up: Floats = blank(0.0)
    down: Floats = blank(0.0)


@inline
def decayed(decay: float, level: float, variance: float) -> tuple[float, float]:
    """Return the level, which decays by `decay` since the last sample, and its variance, relative to slow²."""
    return decay * level, decay * decay * variance + (1.0 - decay * decay)


@inline
def spread_and_gain(white: float, slow: float, variance: float) -> tuple[float, float]:
    """Return the variance of the innovation and the gain of the scalar Kalman filter, for a predicted variance."""
    spread = slow * slow * variance + white * white
    return spread, slow * slow * variance / spread


class CusumSettings(NamedTuple):
    """The numbers of a `Cusum`; (P,) arrays for P profiles."""

    white: Floats
    slow: Floats
    tau_s: Floats
    slack: float
    clip: float
    reach: float
    plausible: float
    margin: float


@always_inline
def _forget(state: CusumState, row: int, alarm: bool) -> None:
    state.level[row], state.variance[row] = 0.0, 1.0
    # An alarm that is held over the gap goes on until ordinary samples end it.
    if not alarm:
        state.up[row], state.down[row] = 0.0, 0.0


@always_inline
def _score(state: CusumState, seen: Observation, i: int, settings: CusumSettings, alarm: bool) -> float:
    row, p = seen.rows[i], seen.profile[i]
    decay = exp(-(seen.elapsed_steps[i] * seen.step_s) / settings.tau_s[p])
    z = seen.residual_m[i] / seen.scale_m[i]
    state.level[row], state.variance[row] = decayed(decay, state.level[row], state.variance[row])
    spread, _ = spread_and_gain(settings.white[p], settings.slow[p], state.variance[row])
    e = min(max((z - state.level[row]) / sqrt(spread), -settings.clip), settings.clip)
    state.up[row] = max(0.0, state.up[row] + e - settings.slack)
    state.down[row] = max(0.0, state.down[row] - e - settings.slack)
    return float(max(state.up[row], state.down[row]))


@always_inline
def _remember(
    state: CusumState, seen: Observation, i: int, settings: CusumSettings, threshold: float, alarm: bool
) -> None:
    row, p = seen.rows[i], seen.profile[i]
    white, slow = settings.white[p], settings.slow[p]
    cap = threshold + settings.margin * settings.slack
    state.up[row], state.down[row] = min(state.up[row], cap), min(state.down[row], cap)
    z = seen.residual_m[i] / seen.scale_m[i]
    if alarm and abs(z) > settings.plausible * sqrt(white * white + slow * slow):
        return
    _, gain = spread_and_gain(white, slow, state.variance[row])
    bound = settings.reach * slow
    state.level[row] = min(max(state.level[row] + gain * (z - state.level[row]), -bound), bound)
    state.variance[row] *= 1.0 - gain


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
    kernel = each_residual(_forget, _score, _remember)
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

    def new_state(self, capacity: int) -> Table[CusumState]:
        """Return sums of 0 for `capacity` rows, whose slow part is not known."""
        return Table(CusumState, capacity)

    @cached_property
    def settings(self) -> CusumSettings:
        """The numbers as the kernel reads them."""
        profiles = (np.asarray(self.white), np.asarray(self.slow), np.asarray(self.tau_s))
        return CusumSettings(*profiles, self.slack, self.clip, self.reach, self.plausible, self.margin)

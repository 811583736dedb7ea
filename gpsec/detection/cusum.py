"""Two-sided CUSUM of the whitened residual."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, sqrt
from typing import ClassVar, Self, cast

import numpy as np

from gpsec.arrays import Flags, Floats, Ints
from gpsec.detection.alarm import (
    GAP_S,
    HOLD_S,
    AlarmState,
    blank_alarm,
    decide,
    gap_before,
    hold,
    run_on,
    steps_in,
)
from gpsec.detection.base import Detector, Observation, Verdict
from gpsec.detection.learned import Learned, scalars
from gpsec.fleet import Rows
from gpsec.kernels import inline, kernel
from gpsec.threads import Threads


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


@dataclass(frozen=True)
class Cusum(Detector):
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
    white: tuple[float, ...]
    slow: tuple[float, ...]
    tau_s: tuple[float, ...]
    slack: float = 0.75
    clip: float = 6.0
    reach: float = 3.0
    plausible: float = 2.5
    margin: float = 3.0

    @classmethod
    def from_learned(cls, learned: Sequence[Learned]) -> Self:
        """Return the detector for profiles in the order of `learned`."""
        return cls(white=scalars(learned, "white"), slow=scalars(learned, "slow"), tau_s=scalars(learned, "tau_s"))

    def new_state(self, capacity: int) -> CusumState:
        """Return the detector's arrays for `capacity` rows."""
        return CusumState.empty(capacity)

    def update(
        self, state: Rows, observation: Observation, threshold: Floats, threads: Threads | None = None
    ) -> Verdict:
        """Take one step."""
        own = cast("CusumState", state)
        verdict = Verdict.blank(len(observation.rows))
        run_on(threads).run(
            _update,
            np.arange(len(observation.rows), dtype=np.int32),
            observation.rows,
            observation.profile,
            observation.residual_m,
            observation.valid,
            observation.scale_m,
            threshold,
            observation.step_s,
            steps_in(GAP_S, observation.step_s),
            steps_in(HOLD_S, observation.step_s),
            np.asarray(self.white),
            np.asarray(self.slow),
            np.asarray(self.tau_s),
            self.slack,
            self.clip,
            self.reach,
            self.plausible,
            self.margin,
            own.level,
            own.variance,
            own.up,
            own.down,
            own.alarm,
            own.since_valid,
            own.since_scored,
            verdict.statistic,
            verdict.scored,
            verdict.alarm,
        )
        return verdict


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


@kernel
def _update(
    part: Ints,
    rows: Ints,
    profile: Ints,
    residual_m: Floats,
    valid: Flags,
    scale_m: Floats,
    threshold: Floats,
    step_s: float,
    gap_steps: int,
    hold_steps: int,
    white: Floats,
    slow: Floats,
    tau_s: Floats,
    slack: float,
    clip: float,
    reach: float,
    plausible: float,
    margin: float,
    level: Floats,
    variance: Floats,
    up: Floats,
    down: Floats,
    alarm: Flags,
    since_valid: Ints,
    since_scored: Ints,
    statistic: Floats,
    scored: Flags,
    alarms: Flags,
) -> None:
    for i in part:
        row = rows[i]
        if not valid[i]:
            since_valid[row] += 1
            hold(i, row, hold_steps, alarm, since_scored, statistic, scored, alarms)
            continue
        p = profile[i]
        elapsed_s = (since_valid[row] + 1) * step_s
        if gap_before(since_valid, row, gap_steps):
            level[row], variance[row] = 0.0, 1.0
            # An alarm that is held over the gap goes on until ordinary samples end it.
            if not alarm[row]:
                up[row], down[row] = 0.0, 0.0
        z = residual_m[i] / scale_m[i]
        decay = exp(-elapsed_s / tau_s[p])
        predicted, spread, innovation, innovation_variance, gain = innovate(
            z, decay, white[p], slow[p], level[row], variance[row]
        )
        e = min(max(innovation / sqrt(innovation_variance), -clip), clip)
        plus = max(0.0, up[row] + e - slack)
        minus = max(0.0, down[row] - e - slack)
        decide(i, row, max(plus, minus), threshold[i], alarm, since_scored, statistic, scored, alarms)
        cap = threshold[i] + margin * slack
        up[row], down[row] = min(plus, cap), min(minus, cap)
        if alarm[row] and abs(z) > plausible * sqrt(white[p] * white[p] + slow[p] * slow[p]):
            level[row], variance[row] = predicted, spread
        else:
            bound = reach * slow[p]
            level[row] = min(max(predicted + gain * innovation, -bound), bound)
            variance[row] = (1.0 - gain) * spread

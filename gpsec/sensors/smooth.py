"""The slow error of a receiver as it is in logs: it wanders smoothly, since the receiver filters what it measures.

The error p of an axis has a rate r that is a Gauss-Markov process, and is held by a leak: r' = -r/τ + white noise with
standard deviation σ of r, p' = -p/T + r. Its power spectrum is 2σ²b/((ω² + a²)(ω² + b²)) with a = 1/T and b = 1/τ.
"""

from dataclasses import dataclass
from math import exp, sqrt

import numpy as np

from gpsec.core.arrays import Floats

# Columns of `ProfileTable.wander`: σ of the rate, its decay and kick over a step; decay of what it has led to, and how
# far a rate leads in a step; σ of that in the long run, and its correlation with the rate.
RATE, RATE_DECAY, RATE_KICK, HOLD_DECAY, GAIN, REACH, TOGETHER = range(7)
NO_WANDER = (0.0,) * 7


@dataclass(frozen=True)
class Wander:
    """An integrated Gauss-Markov process.

    Attributes:
        rate_mps: standard deviation of the rate.
        rate_tau_s: its correlation time.
        hold_s: time constant of the leak.
    """

    rate_mps: float
    rate_tau_s: float
    hold_s: float

    def covariance_m2(self, lag_s: Floats) -> Floats:
        """Return the autocovariance of p after (n,) lags: σ²b/(b² - a²)·(exp(-at)/a - exp(-bt)/b)."""
        a, b = 1.0 / self.hold_s, 1.0 / self.rate_tau_s
        if abs(a - b) < 1e-6 * b:
            b = a * (1.0 + 1e-6)  # the limit, to six digits
        scale = self.rate_mps**2 * b / (b * b - a * a)
        found: Floats = scale * (np.exp(-a * lag_s) / a - np.exp(-b * lag_s) / b)
        return found

    @property
    def sigma_m(self) -> float:
        """Standard deviation of p: σ·√(1/(a(a + b)))."""
        a, b = 1.0 / self.hold_s, 1.0 / self.rate_tau_s
        return float(self.rate_mps / np.sqrt(a * (a + b)))

    def structure_m2(self, lag_s: Floats) -> Floats:
        """Return the mean square of how far p goes in (n,) lags."""
        none = np.zeros(1)
        found: Floats = 2.0 * (self.covariance_m2(none)[0] - self.covariance_m2(np.asarray(lag_s, float)))
        return np.maximum(found, 0.0)


def wander_row(wander: Wander | None, step_s: float) -> tuple[float, ...]:
    """Return the columns of a wander for steps of a length; zeros for none."""
    if wander is None:
        return NO_WANDER
    decay, held = exp(-step_s / wander.rate_tau_s), exp(-step_s / wander.hold_s)
    together = wander.rate_mps / ((1.0 / wander.hold_s + 1.0 / wander.rate_tau_s) * wander.sigma_m)
    kick = wander.rate_mps * sqrt(1.0 - decay * decay)
    return (wander.rate_mps, decay, kick, held, (1.0 - held) * wander.hold_s, wander.sigma_m, together)

"""Two-sided CUSUM of what the LSTM did not expect."""

from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import ClassVar, NamedTuple

from gpsec.core.arrays import Floats, Floats32
from gpsec.core.kernels import always_inline, inline
from gpsec.core.tables import Table, blank
from gpsec.detection.base import Observation
from gpsec.detection.families import each_block
from gpsec.detection.forecast import (
    Forecaster,
    ForecastSettings,
    ForecastState,
    foresee,
    forget,
    remember,
    workspace,
)
from gpsec.detection.lstm_cell import CELL_BLOCK, SCALES, Step
from gpsec.detection.lstm_glr import DECAYS

# By how much more a slow error of prediction adds to the variance at the slowest scale than to that of a single error.
_SLOW_GAIN = (1.0 + DECAYS[-1]) / (1.0 - DECAYS[-1]) - 1.0


class LstmCusumState(NamedTuple):
    """M rows.

    Attributes:
        forecast: of the network.
        up, down: (M,) sums of positive and of negative errors of prediction.
    """

    forecast: ForecastState = ForecastState()
    up: Floats = blank(0.0)
    down: Floats = blank(0.0)


class LstmCusumSettings(NamedTuple):
    """The numbers of an `LstmCusum`."""

    forecast: ForecastSettings
    slack: float
    reach: float
    clip: float
    margin: float


@inline
def _slack(output: Floats32, settings: LstmCusumSettings) -> float:
    """Return k for what the network says."""
    slow = max(1.0 / output[SCALES] - 1.0 / output[1], 0.0) / _SLOW_GAIN
    return settings.slack + settings.reach * sqrt(slow * output[1])


@always_inline
def _forget(state: LstmCusumState, row: int, alarm: bool) -> None:
    forget(state.forecast, row)
    # An alarm that is held over the gap goes on until ordinary samples end it.
    if not alarm:
        state.up[row], state.down[row] = 0.0, 0.0


@always_inline
def _score(
    state: LstmCusumState, seen: Observation, i: int, settings: LstmCusumSettings, alarm: bool, work: Step, n: int
) -> float:
    row, output = seen.rows[i], work.output[n]
    z = seen.residual_m[i] / seen.scale_m[i]
    e = min(max((z - output[0]) * sqrt(output[1]), -settings.clip), settings.clip)
    k = _slack(output, settings)
    state.up[row] = max(0.0, state.up[row] + e - k)
    state.down[row] = max(0.0, state.down[row] - e - k)
    return float(max(state.up[row], state.down[row]))


@always_inline
def _remember(
    state: LstmCusumState,
    seen: Observation,
    i: int,
    settings: LstmCusumSettings,
    threshold: float,
    alarm: bool,
    work: Step,
    n: int,
) -> None:
    row, output = seen.rows[i], work.output[n]
    cap = threshold + settings.margin * _slack(output, settings)
    state.up[row], state.down[row] = min(state.up[row], cap), min(state.down[row], cap)
    z = seen.residual_m[i] / seen.scale_m[i]
    remember(state.forecast, row, z, output[0], settings.forecast, alarm)


@dataclass(frozen=True)
class LstmCusum(Forecaster):
    """Page's cumulative sums of the errors of the LSTM's prediction, in units of the deviation that it expects.

    With e = (z - ẑ)/σ clipped to ±c,

        S⁺ ← max(0, S⁺ + e - k),   S⁻ ← max(0, S⁻ - e - k),   statistic = max(S⁺, S⁻).

    k = slack + reach·σ_s/σ, where σ_s is the deviation of the part of the error that lasts: sums of what lasts would
    wander off without an attack. It follows from what the network expects at its fastest and its slowest scale, as a
    lasting error is in the variance of the latter (1 + λ)/(1 - λ) times. The network is that of `lstm_glr`. The sums
    are capped at threshold + margin·k, as in `cusum`.

    Attributes:
        slack, reach: see above.
        clip: c.
        margin: see above.
    """

    name: ClassVar[str] = "lstm_cusum"
    kernel = each_block(CELL_BLOCK, workspace, foresee, _forget, _score, _remember)
    slack: float = 0.5
    reach: float = 2.5
    clip: float = 6.0
    margin: float = 1.0

    def new_state(self, capacity: int) -> Table[LstmCusumState]:
        """Return what is remembered of `capacity` rows that have seen nothing."""
        return Table(LstmCusumState, capacity, delay=self.delay)

    @cached_property
    def settings(self) -> LstmCusumSettings:
        """The numbers as the kernel reads them."""
        return LstmCusumSettings(self.forecast, self.slack, self.reach, self.clip, self.margin)

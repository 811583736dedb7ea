"""Generalised likelihood ratio of an LSTM's errors: what became of Eq 10 where it has to see slow attacks."""

from dataclasses import dataclass
from functools import cached_property
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
    remember_residual,
    workspace,
)
from gpsec.detection.lstm_cell import CELL_BLOCK, SCALES, Step

# Weight of an error of prediction relative to that of the next one, at each time scale: this sample alone, and means
# over the last 2.5 and 6.7 of them. An attack that grows by 1/decay a sample is seen best at the scale of that decay.
DECAYS = (0.0, 0.6, 0.85)


class LstmGlrState(NamedTuple):
    """M rows.

    Attributes:
        forecast: of the network.
        evidence: (M, S) weighted sums of the errors of prediction.
        weight: (M, S) sums of the squared weights.
    """

    forecast: ForecastState = ForecastState()
    evidence: Floats = blank(0.0, SCALES)
    weight: Floats = blank(0.0, SCALES)


class LstmGlrSettings(NamedTuple):
    """The numbers of an `LstmGlr`."""

    forecast: ForecastSettings
    enough: float


@inline
def contradicts(evidence: Floats, weight: Floats, row: int, error: float, output: Floats32, enough: float) -> bool:
    """Return whether an error of prediction is much likelier without the offset that was seen so far than with it.

    That offset m is the mean at the scale with the largest statistic, and the logarithm of the likelihood ratio of
    e ~ N(m, σ²) and e ~ N(0, σ²) is (m·e - m²/2)/σ².
    """
    largest, offset = 0.0, 0.0
    for s in range(SCALES):
        if weight[row, s] > 0.0:
            value = evidence[row, s] * evidence[row, s] / weight[row, s] * output[1 + s]
            if value > largest:
                largest, offset = value, evidence[row, s] * (1.0 - DECAYS[s])
    return bool((offset * error - 0.5 * offset * offset) * output[1] < -enough)


@inline
def _forget_evidence(state: LstmGlrState, row: int) -> None:
    for s in range(SCALES):
        state.evidence[row, s] = 0.0
        state.weight[row, s] = 0.0


@always_inline
def _forget(state: LstmGlrState, row: int, alarm: bool) -> None:
    forget(state.forecast, row)
    _forget_evidence(state, row)


@always_inline
def _score(
    state: LstmGlrState, seen: Observation, i: int, settings: LstmGlrSettings, alarm: bool, work: Step, n: int
) -> float:
    row, output = seen.rows[i], work.output[n]
    evidence, weight = state.evidence, state.weight
    error = seen.residual_m[i] / seen.scale_m[i] - output[0]
    if alarm and contradicts(evidence, weight, row, error, output, settings.enough):
        _forget_evidence(state, row)
    value = 0.0
    for s in range(SCALES):
        evidence[row, s] = DECAYS[s] * evidence[row, s] + error
        weight[row, s] = DECAYS[s] * DECAYS[s] * weight[row, s] + 1.0
        value = max(value, evidence[row, s] * evidence[row, s] / weight[row, s] * output[1 + s])
    return value


@dataclass(frozen=True)
class LstmGlr(Forecaster):
    """Squared error of an LSTM's prediction of the residual, in units of the variance that the network expects of it.

    With the errors e = (z - ẑ)/scale, time scales of decay λ, and σ_λ² as the network predicts it,

        ξ = max over λ of (Σ λʲ·e_{t-j})² / (Σ λ²ʲ · σ_λ²).

    This is Eq 10 (ξ = (z - ẑ)² at λ = 0) with three changes: errors are averaged before they are squared, since an
    attack moves all of them to one side and noise does not; over several windows at once, since it is not known how
    fast the attack is; and each in units of its own variance. While in alarm, an error that is `enough` times (as a
    logarithm) likelier without the offset than with it ends the evidence: the attack is over, and so is the alarm.

    Attributes:
        enough: see above.
    """

    name: ClassVar[str] = "lstm_glr"
    kernel = each_block(CELL_BLOCK, workspace, foresee, _forget, _score, remember_residual)
    enough: float = 3.0

    def new_state(self, capacity: int) -> Table[LstmGlrState]:
        """Return what is remembered of `capacity` rows that have seen nothing."""
        return Table(LstmGlrState, capacity, delay=self.delay)

    @cached_property
    def settings(self) -> LstmGlrSettings:
        """The numbers as the kernel reads them."""
        return LstmGlrSettings(self.forecast, self.enough)

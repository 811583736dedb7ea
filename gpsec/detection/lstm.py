"""LSTM that predicts the next residual, and the mean of its squared errors: Eq 10 as the paper writes it."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import always_inline
from gpsec.core.tables import Table, blank
from gpsec.detection.base import Observation
from gpsec.detection.families import NOT_YET, each_block
from gpsec.detection.forecast import (
    Forecaster,
    ForecastSettings,
    ForecastState,
    foresee,
    forget,
    remember_residual,
    workspace,
)
from gpsec.detection.lstm_cell import CELL_BLOCK, Step
from gpsec.detection.ring import mean, push


class LstmSettings(NamedTuple):
    """The numbers of an `Lstm`."""

    forecast: ForecastSettings


class LstmState(NamedTuple):
    """M rows.

    Attributes:
        forecast: of the network.
        square: (M, n) ring of the last squared errors of prediction.
        counted: (M,) how many of them have been seen.
    """

    forecast: ForecastState = ForecastState()
    square: Floats = blank(0.0, "window")
    counted: Ints = blank(0)


@always_inline
def _forget(state: LstmState, row: int, alarm: bool) -> None:
    forget(state.forecast, row)
    state.counted[row] = 0


@always_inline
def _score(
    state: LstmState, seen: Observation, i: int, settings: LstmSettings, alarm: bool, work: Step, n: int
) -> float:
    row = seen.rows[i]
    error = seen.residual_m[i] / seen.scale_m[i] - work.output[n, 0]
    return mean(state.square, row) if push(state.square, state.counted, row, error * error) else NOT_YET


@dataclass(frozen=True)
class Lstm(Forecaster):
    """Mean of the last n squared errors of an LSTM's one-step prediction of the residual (Eq 10).

    ξ = (1/n)·Σ ((z - ẑ)/scale)², where ẑ is made of the residuals up to the one before. The paper does not give n.

    Attributes:
        window: n; scoring begins with the n-th sample.
    """

    name: ClassVar[str] = "lstm"
    delay: ClassVar[int] = 1
    outputs: ClassVar[int] = 1
    kernel = each_block(CELL_BLOCK, workspace, foresee, _forget, _score, remember_residual)
    window: int = 2

    def new_state(self, capacity: int) -> Table[LstmState]:
        """Return what is remembered of `capacity` rows that have seen nothing."""
        return Table(LstmState, capacity, delay=self.delay, window=self.window)

    @cached_property
    def settings(self) -> LstmSettings:
        """The numbers as the kernel reads them."""
        return LstmSettings(self.forecast)

"""Chi-square test of the residual."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from gpsec.core.arrays import Floats, Ints
from gpsec.core.kernels import always_inline
from gpsec.core.tables import Table, blank
from gpsec.detection.base import Observation
from gpsec.detection.families import NOT_YET, KernelDetector, each_residual
from gpsec.detection.ring import mean, push


class ChiSquareState(NamedTuple):
    """M rows.

    Attributes:
        square: (M, n) ring of the last squared normalised residuals.
        counted: (M,) how many of them have been seen.
    """

    square: Floats = blank(0.0, "window")
    counted: Ints = blank(0)


@always_inline
def _forget(state: ChiSquareState, row: int, alarm: bool) -> None:
    state.counted[row] = 0


@always_inline
def _score(state: ChiSquareState, seen: Observation, i: int, settings: tuple[()], alarm: bool) -> float:
    row = seen.rows[i]
    z = seen.residual_m[i] / seen.scale_m[i]
    return mean(state.square, row) if push(state.square, state.counted, row, z * z) else NOT_YET


@dataclass(frozen=True)
class ChiSquare(KernelDetector):
    """Mean of the last n squared residuals in units of what the sensor profile promises.

    q = (1/n)·Σ (z/scale)²: n·q has a chi-square distribution with n degrees of freedom when the residual is white.

    Attributes:
        window: n; scoring begins with the n-th sample.
    """

    name: ClassVar[str] = "chi_square"
    heeds_alarm: ClassVar[bool] = False
    kernel = each_residual(_forget, _score)
    window: int = 2

    def new_state(self, capacity: int) -> Table[ChiSquareState]:
        """Return empty windows for `capacity` rows."""
        return Table(ChiSquareState, capacity, window=self.window)

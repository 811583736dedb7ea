"""Energy: the mean square of the last residuals, in plain numpy."""

from typing import ClassVar

from gpsec.core.arrays import Floats, Ints
from gpsec.detection.plain import WindowDetector


class Energy(WindowDetector):
    """Mean square of the last five normalised residuals."""

    name: ClassVar[str] = "energy"
    samples: ClassVar[int] = 5
    fixed_threshold: ClassVar[float] = 4.0

    def score(self, windows: Floats, profile: Ints) -> Floats:
        """Return the mean squares; a sum over five columns, so that a row has the same bits in any company."""
        total = windows[:, 0] ** 2
        for column in range(1, self.samples):
            total = total + windows[:, column] ** 2
        return total / self.samples

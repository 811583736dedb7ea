"""What a lane camera does beside Gaussian noise, as columns for kernels."""

from math import exp, sqrt
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gpsec.sensors.profiles import Camera

# Columns of `ProfileTable.faults`: share of samples in the tails, and their σ over that of all; correlation of the
# white errors of C0 and C1; probability per step that a wrong line is taken, and left; how far it is off; σ of the
# samples that are not in the tails over that of all.
TAIL_SHARE, TAIL_FACTOR, SLOPE, LINE_BEGIN, LINE_END, LINE_M, CORE_FACTOR = range(7)
NO_FAULTS = (0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0)


def fault_row(camera: "Camera", step_s: float) -> tuple[float, ...]:
    """Return the columns of a camera for steps of a length."""
    per_h, lasts_s = camera.wrong_line_per_h or 0.0, camera.wrong_line_mean_s or 0.0
    share, factor = camera.tail_share or 0.0, camera.tail_factor or 1.0
    core = 1.0 / sqrt(1.0 - share + share * factor * factor)
    return (
        share,
        factor * core,
        camera.slope_correlation or 0.0,
        1.0 - exp(-per_h * step_s / 3600.0),
        1.0 - exp(-step_s / lasts_s) if lasts_s > 0.0 else 1.0,
        camera.wrong_line_m or 0.0,
        core,
    )

"""The figure of what was measured: distribution and memory of the error of C0, for each weather."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from gpsec.core.system import in_a_sentence
from gpsec.imaging.filming.error_table import correlations
from gpsec.imaging.filming.measure import Errors

# Okabe and Ito.
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")


def draw_profile(measured: Mapping[str, Sequence[Errors]], step_s: float, path: Path) -> None:
    """Draw, for each weather, how the error of C0 is distributed and how long it lasts, as a PNG.

    Raises:
        GpsecError: it cannot be written.
    """
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.4), layout="constrained")
    for (weather, all_errors), colour in zip(measured.items(), _COLOURS * 9, strict=False):
        size = np.sort(np.abs(np.concatenate([errors.single[errors.found, 0] for errors in all_errors])))
        if not len(size):
            continue
        left.plot(size, 1.0 - np.arange(len(size)) / len(size), color=colour, label=weather)
        for kind, style in (("single", "-"), ("kept", "--")):
            series = [(getattr(errors, kind)[:, 0], errors) for errors in all_errors]
            curve = correlations(series, round(4.0 / step_s))
            right.plot(step_s * np.arange(len(curve)), curve, style, color=colour)
    left.set(xlabel="size of the error of C0 (m)", ylabel="share of pictures beyond", yscale="log", xlim=(0.0, 0.6))
    right.set(xlabel="time (s)", ylabel="autocorrelation (dashed: with memory)", ylim=(-0.2, 1.0))
    left.legend(frameon=False)
    for axes in (left, right):
        axes.grid(alpha=0.3)
    with in_a_sentence(f"{path}: no figure can be written there"):
        figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)

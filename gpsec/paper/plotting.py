"""What all figures share: size, colours for colour-blind readers, curves with intervals."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gpsec.outcomes.tables import whole
from gpsec.paper.pool import Estimate

Axes = Any

# Okabe and Ito, "Color Universal Design" (2008).
_PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999")


class _Colours:
    """Gives every name the next colour, the same in all figures; when all are given, lines are dashed."""

    def __init__(self) -> None:
        self._given: dict[str, int] = {}

    def __call__(self, name: str) -> str:
        return _PALETTE[self._number(name) % len(_PALETTE)]

    def line(self, name: str) -> str:
        """Return the line style that goes with the colour."""
        return "-" if self._number(name) < len(_PALETTE) else "--"

    def _number(self, name: str) -> int:
        return self._given.setdefault(name, len(self._given))


LINE_COLOURS = _Colours()


@contextmanager
def canvas(path: Path, rows: int, columns: int, size: tuple[float, float] = (3.6, 2.6)) -> Iterator[Any]:
    """Yield (rows, columns) axes; afterwards write them as a picture with a legend below."""
    figure = Figure(figsize=(size[0] * columns, size[1] * rows + 0.5), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False)
    for one in axes.flat:
        one.grid(color="0.9", linewidth=0.6)
        one.set_axisbelow(True)
    yield axes
    legend: dict[str, Any] = {}
    for one in axes.flat:
        for handle, label in zip(*one.get_legend_handles_labels(), strict=True):
            legend.setdefault(label, handle)
    if legend:
        figure.legend(
            legend.values(), legend.keys(), loc="outside lower center", ncols=min(len(legend), 5), frameon=False
        )
    save_picture(figure, path)


def save_picture(figure: Figure, path: Path) -> None:
    """Write a picture without the time and program in its metadata, so that its bytes are reproducible."""
    with whole(path) as partial:
        figure.savefig(partial, format="png", dpi=110, metadata={"Software": None})


def draw_curve(axes: Axes, x: Sequence[float], found: Sequence[Estimate], label: str, line: str = "") -> None:
    """Draw estimates with their intervals as a band; what is undefined leaves a gap."""
    value, low, high = (
        np.array([np.nan if part is None else part for part in parts], np.float64)
        for parts in zip(*((each.value, each.low, each.high) for each in found), strict=True)
    )
    name = label.partition(",")[0]
    colour = LINE_COLOURS(name)
    axes.plot(
        x, value, line or LINE_COLOURS.line(name), color=colour, label=label, linewidth=1.3, marker=".", markersize=4
    )
    axes.fill_between(x, low, high, color=colour, alpha=0.15, linewidth=0)

"""The one style of figures for print: column widths, colours for colour-blind readers, embedded fonts."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

from matplotlib import rc_context
from matplotlib.figure import Figure

from gpsec.outcomes.tables import whole

Width = Literal["column", "text"]
# Inches, of a two-column page as IEEE and most conferences have it.
_WIDTHS = {"column": 3.5, "text": 7.16}
_HEIGHT = 2.4
# Okabe and Ito, "Color Universal Design" (2008); black is for the undefended vehicle.
_PALETTE = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9", "#999999")
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")
_DASHES = ("-", "--", ":", "-.")
_STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # comes with matplotlib, so that it is the same everywhere
    "font.size": 8.0,
    "axes.labelsize": 8.0,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 6.5,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "0.88",
    "grid.linewidth": 0.5,
    "axes.axisbelow": True,
    "lines.linewidth": 1.2,
    "lines.markersize": 3.5,
    "pdf.fonttype": 42,  # TrueType, as journals ask for; Type 3 is refused by some
    "svg.fonttype": "path",  # the letters themselves, so that no font is missing anywhere
    "svg.hashsalt": "gpsec",
}


class LineLooks:
    """How each of a few names is drawn: every one differs from the others in colour and in marker or dashes."""

    def __init__(self, names: Sequence[str], plain: str = "") -> None:
        self._number = {name: place for place, name in enumerate(name for name in names if name != plain)}

    def of(self, name: str) -> dict[str, Any]:
        """Return matplotlib's keywords for a line."""
        if name not in self._number:
            return {"color": "black", "linestyle": "-", "marker": "x"}
        number = self._number[name]
        turn = number // len(_PALETTE)
        return {
            "color": _PALETTE[number % len(_PALETTE)],
            "linestyle": _DASHES[(number + turn) % len(_DASHES)],
            "marker": _MARKERS[(number + turn) % len(_MARKERS)],
        }


@contextmanager
def printed(path: Path, width: Width, rows: int = 1, columns: int = 1) -> Iterator[Any]:
    """Yield (rows, columns) axes; afterwards write them, with one legend below, as the ending of `path` says."""
    with rc_context(_STYLE):
        figure = Figure(figsize=(_WIDTHS[width], _HEIGHT * rows), layout="constrained")
        axes = figure.subplots(rows, columns, squeeze=False)
        yield axes
        legend: dict[str, Any] = {}
        for one in axes.flat:
            for handle, label in zip(*one.get_legend_handles_labels(), strict=True):
                legend.setdefault(label, handle)
        if legend:
            across = 2 if width == "column" else 4
            figure.legend(
                legend.values(),
                legend.keys(),
                loc="outside lower center",
                ncols=min(len(legend), across),
                frameon=False,
            )
            figure.set_size_inches(_WIDTHS[width], _HEIGHT * rows + 0.16 * -(-len(legend) // across))
        kind = path.suffix.removeprefix(".")
        stated = {"CreationDate": None} if kind == "pdf" else {"Date": None}
        drawn = BytesIO()
        figure.savefig(drawn, format=kind, metadata=stated)
        with whole(path) as partial:
            partial.write_bytes(drawn.getvalue())

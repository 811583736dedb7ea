"""Figures as plain data, which `assets/report.js` draws with Plotly."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

# Digits that a figure keeps of a number: a tenth of a pixel of any axis.
_DIGITS = 4
Values = Sequence[Any] | NDArray[Any]

# As many colours can be told apart.
_COLOURS = 6
# Colour of what is not coloured: the undefended vehicle, the road.
NEUTRAL = -1


@dataclass(frozen=True)
class Series:
    """One line, band, set of points or of bars.

    Attributes:
        name: in the legend and in the CSV.
        kind: ``line``, ``step``, ``band``, ``points``, ``trail`` (both), ``bars``, ``road``, ``heat``, ``area``,
            ``span``.
        x, y: values; NaN breaks a line.
        low, high: bounds of `y`, where there are any; x_low, x_high: of `x`.
        colour: number of a colour, `NEUTRAL` for that of the text.
        where: the selections under which it is shown, such as ``{"group": "town · carla", "attack": "drift"}``.
        text: of the points.
        mark: Plotly's symbol of points.
        of: name of the series that it goes with: it is hidden with that, and has no place of its own in the legend.

    """

    name: str
    kind: str
    x: Values
    y: Values
    low: Values | None = None
    high: Values | None = None
    x_low: Values | None = None
    x_high: Values | None = None
    colour: int = NEUTRAL
    where: Mapping[str, str] = field(default_factory=dict)
    text: Sequence[str] | None = None
    mark: str = ""
    of: str = ""


@dataclass(frozen=True)
class Figure:
    """A figure, with the sentence that stands in place of an empty one.

    Attributes:
        key: an id.
        title, note: above and below it.
        x_title, y_title: of the axes, with units.
        series: what is drawn.
        why_empty: a sentence for choices under which there is no series.
        layout: further settings of Plotly's axes and bars.
        tall: needs more height than width.
        labelled: lines have their names at their ends, where there is room.

    """

    key: str
    title: str
    x_title: str
    y_title: str
    series: Sequence[Series]
    why_empty: str
    note: str = ""
    layout: Mapping[str, Any] = field(default_factory=dict)
    tall: bool = False
    labelled: bool = False

    @property
    def picks(self) -> dict[str, list[str]]:
        """Selectors of this figure, other than group and attack -> their options."""
        found: dict[str, dict[str, None]] = {}
        for series in self.series:
            for name, value in series.where.items():
                if name not in {"group", "attack"}:
                    found.setdefault(name, {})[value] = None
        return {name: list(values) for name, values in found.items()}

    def plain(self) -> dict[str, Any]:
        """Return the figure as plain data for JSON."""
        return {
            "key": self.key,
            "title": self.title,
            "xTitle": self.x_title,
            "yTitle": self.y_title,
            "whyEmpty": self.why_empty,
            "layout": dict(self.layout),
            "tall": self.tall,
            "labelled": self.labelled,
            "picks": self.picks,
            "series": [_plain(series) for series in self.series],
        }


def _plain(series: Series) -> dict[str, Any]:
    values = {
        "x": series.x,
        "y": series.y,
        "low": series.low,
        "high": series.high,
        "xLow": series.x_low,
        "xHigh": series.x_high,
    }
    plain: dict[str, Any] = {"name": series.name, "kind": series.kind, "colour": series.colour}
    plain |= {name: _column(column) for name, column in values.items() if column is not None}
    plain["where"] = dict(series.where)
    if series.text is not None:
        plain["text"] = list(series.text)
    plain |= {name: value for name, value in (("mark", series.mark), ("of", series.of)) if value}
    return plain


def _column(values: Values) -> list[Any]:
    """Return numbers in `_DIGITS` digits, or to a tenth where they are larger, None for NaN; texts as they are."""
    if len(values) and isinstance(values[0], str):
        return list(values)
    numbers = np.asarray(values, np.float64)
    finite = np.isfinite(numbers)
    size = np.log10(np.where(finite & (numbers != 0.0), np.abs(numbers), 1.0))
    scale = 10.0 ** np.clip(_DIGITS - 1 - np.floor(size), 1, 15)
    short = np.rint(np.where(finite, numbers, 0.0) * scale) / scale
    plain = [int(value) if value == int(value) else value for value in short.tolist()]
    return [value if known else None for value, known in zip(plain, finite.tolist(), strict=True)]


def colours(names: Iterable[str], neutral: str = "") -> dict[str, int]:
    """Return a style for each name, the same wherever the name appears: `styleOf` in ``legend.js`` says what it is.

    Names that begin with the same detector share a colour, as long as there are enough, and differ in dash and mark;
    `neutral` has none.
    """
    found, firsts = {neutral: NEUTRAL}, dict[str, int]()
    taken = [0] * _COLOURS
    for name in dict.fromkeys(names):
        if name == neutral:
            continue
        first = firsts.setdefault(name.partition("+")[0].partition("@")[0], len(firsts) % _COLOURS)
        found[name] = first + _COLOURS * taken[first]
        taken[first] += 1
    return found


def group_name(scenario: str, profile: str) -> str:
    """Return the title of a scenario with a profile, as the report's selector shows it."""
    return f"{scenario} · {profile}"


def grouped(table: pd.DataFrame, key: str) -> Iterable[tuple[dict[str, str], str, dict[str, Any]]]:
    """Yield (where, name, columns) for every scenario, profile, attack and value of `key`, as they first appear."""
    columns = {str(name): table[name].to_numpy() for name in table}
    found = table.groupby(["scenario", "profile", "attack", key], sort=False, observed=True).indices
    for names, places in sorted(found.items(), key=lambda item: int(item[1][0])):
        scenario, profile, attack, name = map(str, names)  # type: ignore[call-overload]  # pandas-stubs has one key
        where = {"group": group_name(scenario, profile), "attack": attack}
        yield where, name, {column: values[places] for column, values in columns.items()}

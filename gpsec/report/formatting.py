"""Rows of tables, and numbers as a page shows them."""

from collections.abc import Hashable
from typing import Any

import pandas as pd

EMPTY = "–"

Record = dict[Hashable, Any]
"""A row of a table, column -> value, as pandas returns it."""


def figure(value: float, *, percent: bool = False) -> str:
    """Return a number with two or three significant digits; a dash where it is undefined."""
    if pd.isna(value):
        return EMPTY
    if percent:
        digits = 0 if value >= 0.0995 or value == 0.0 else 1
        return f"{_fixed(100.0 * value, digits)} %"
    size = abs(value)
    return _fixed(value, 0 if size >= 99.5 else 1 if size >= 9.95 else 2)


def lacked(area: float) -> str:
    """Return what an area lacks of 1, with two significant digits; a dash where it is undefined."""
    return EMPTY if pd.isna(area) else f"{max(1.0 - area, 0.0):.2g}"


def _fixed(value: float, digits: int) -> str:
    """Return a number with so many decimals; one that rounds to zero has no sign."""
    text = f"{value:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0.0 else text


def interval(row: Any, name: str, *, percent: bool = False) -> str:
    """Return the interval of a figure of a table's row; empty where it has none."""
    low, high = row[f"{name}_lo"], row[f"{name}_hi"]
    if pd.isna(low) or pd.isna(high):
        return ""
    return f"{figure(low, percent=percent)} – {figure(high, percent=percent)}"


def seconds(value: float) -> str:
    """Return a time in seconds, or in minutes and seconds from 90 s on."""
    if value < 90.0:
        return f"{value:.3g} s"
    minutes, rest = divmod(round(value), 60)
    return f"{minutes} min" + (f" {rest} s" if rest else "")

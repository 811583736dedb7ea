"""Rows of tables, and numbers as a page shows them."""

from collections.abc import Hashable
from typing import Any

import pandas as pd

EMPTY = "–"

Record = dict[Hashable, Any]
"""A row of a table, column -> value, as pandas returns it."""


def figure(value: float, *, percent: bool = False) -> str:
    """Return a number in as many digits as are of use; a dash where it is not defined."""
    if pd.isna(value):
        return EMPTY
    if percent:
        return f"{100.0 * value:.0f} %" if value >= 0.0995 or value == 0.0 else f"{100.0 * value:.1f} %"
    size = abs(value)
    return f"{value:.0f}" if size >= 99.5 else f"{value:.1f}" if size >= 9.95 else f"{value:.2f}"


def interval(row: Any, name: str, *, percent: bool = False) -> str:
    """Return the interval of a figure of a table's row; empty where it has none."""
    low, high = row[f"{name}_lo"], row[f"{name}_hi"]
    if pd.isna(low) or pd.isna(high):
        return ""
    return f"{figure(low, percent=percent)} – {figure(high, percent=percent)}"


def seconds(value: float) -> str:
    """Return a time as people say it."""
    if value < 90.0:
        return f"{value:.3g} s"
    minutes, rest = divmod(round(value), 60)
    return f"{minutes} min" + (f" {rest} s" if rest else "")

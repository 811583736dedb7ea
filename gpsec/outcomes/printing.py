"""Shapes of what is printed: titles, tables with names at the left, figures as cells."""

import re
import textwrap
from collections.abc import Hashable, Iterable, Sequence
from typing import Any

import pandas as pd
from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

# Of a column in which there are figures.
HEADING_WIDTH = 14
# Names are folded beyond the widest, and never squeezed below the narrowest.
NARROWEST_LABEL = 10
WIDEST_LABEL = 24
# Wider than any table, to measure what one needs.
_UNLIMITED = 10_000
EMPTY_CELL = "–"
_FORM: dict[str, Any] = {
    "box": box.SIMPLE_HEAD,
    "padding": (0, 1, 0, 0),
    "show_edge": False,
}

Row = dict[Hashable, Any]
Manifest = dict[str, Any]


def run_name(run: Manifest) -> str:
    """Return the scenario of a run, empty where its manifest does not tell."""
    return str(run.get("scenario", ""))


def title_line(text: str) -> Text:
    """Return the title of a table."""
    return Text(f"\n{text}", style="bold")


def caption_line(text: str) -> Text:
    """Return what is said below a table."""
    return Text(f"{text}\n", style="italic")


def labelled_table(label: str, widest: int) -> Table:
    """Return a table whose first column has names, at most so wide."""
    table = Table(**_FORM)
    add_label(table, label, widest)
    return table


def add_label(table: Table, heading: str, widest: int) -> None:
    """Add a column of names, which are folded where they are wider, and where figures need the room."""
    table.add_column(heading, overflow="fold", min_width=NARROWEST_LABEL, max_width=widest)


def fits_console(table: Table, console: Console) -> bool:
    """Say whether the console has room for all figures and for names as wide as they may be."""
    needed = Measurement.get(console, console.options.update(max_width=_UNLIMITED), table).maximum
    return needed <= console.width


def filled_lines(items: Iterable[str], console: Console) -> str:
    """Return items one after the other, indented, with line breaks between but never within them."""
    kept = "  ".join(item.replace(" ", "\N{NO-BREAK SPACE}") for item in items)
    filled = textwrap.fill(
        kept,
        console.width,
        initial_indent="  ",
        subsequent_indent="    ",
        break_long_words=False,
        break_on_hyphens=False,
    )
    return filled.replace("\N{NO-BREAK SPACE}", " ")


def counted_things(number: int, thing: str) -> str:
    """Return a number and its noun, in the plural where it has to be."""
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"


def narrow_heading(defence: str) -> str:
    """Return a heading of several lines, broken where a name is joined."""
    lines = [""]
    for word in re.findall(r"\+?[^_+]+_?", defence):
        if word.startswith("+") or len(lines[-1]) + len(word) > HEADING_WIDTH:
            lines.append("")
        lines[-1] += word
    return "\n".join(line for line in lines if line)


def with_interval(row: Row, name: str) -> str:
    """Return the figure `name` of a row and its interval, as `name`_lo and `name`_hi have it."""
    if pd.isna(row[name]):
        return EMPTY_CELL
    if pd.isna(row[f"{name}_hi"]):
        return without_interval(row, name)
    digits = 2 if row[f"{name}_hi"] < 9.995 else 1
    middle, low, high = (f"{row[key]:.{digits}f}" for key in (name, f"{name}_lo", f"{name}_hi"))
    return f"{middle} {low}–{high}"


def without_interval(row: Row, name: str) -> str:
    """Return the figure `name` of a row."""
    return number_cell(row[name], ".2f" if row[name] < 9.995 else ".1f")


def triple_of(values: Sequence[float]) -> str:
    """Return three figures of four characters each, so that six defences fit the width."""
    return "/".join(_four(value) for value in values)


def _four(value: float) -> str:
    if pd.isna(value):
        return EMPTY_CELL
    if value < 0.0995:
        return f"{value:.3f}".removeprefix("0")
    return f"{value:.2f}" if value < 9.995 else f"{value:.1f}" if value < 99.95 else f"{value:.0f}"


def number_cell(value: float | None, form: str) -> str:
    """Return a figure in a form of `format`, a dash where there is none."""
    return EMPTY_CELL if value is None or pd.isna(value) else format(value, form)

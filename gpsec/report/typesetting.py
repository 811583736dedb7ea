"""Tables as LaTeX or Markdown."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

_SPECIAL = {
    **{letter: f"\\{letter}" for letter in "&%$#_{}"},
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "–": "--",
    "±": r"$\pm$",
    "−": "$-$",
    "×": r"$\times$",
    "γ": r"$\gamma$",
    "δ": r"$\delta$",
    "·": r"$\cdot$",
}


@dataclass(frozen=True)
class TypesetTable:
    """A table for a paper.

    Attributes:
        label: for references to it.
        caption: what it shows, with the number of vehicles, seeds and intervals.
        headings: of the columns; the first `texts` of them are texts, set left.
        rows: cells; None draws a line.
        texts: number of text columns.
    """

    label: str
    caption: str
    headings: Sequence[str]
    rows: Sequence[Sequence[str] | None]
    texts: int = 2


def label(name: str, scenario: str, profile: str) -> str:
    """Return the label of a table of a scenario and profile."""
    return f"{name}-{scenario}-{profile}".replace("_", "-")


def ruled(lines: Sequence[Sequence[str]]) -> list[Sequence[str] | None]:
    """Return rows with a line wherever the first cell changes."""
    found: list[Sequence[str] | None] = []
    for place, line in enumerate(lines):
        if place and line[0] != lines[place - 1][0]:
            found.append(None)
        found.append(line)
    return found


def as_latex(table: TypesetTable) -> str:
    """Return a table as LaTeX for the package booktabs."""
    columns = "l" * table.texts + "r" * (len(table.headings) - table.texts)
    lines = [r"\begin{table}", r"\centering", rf"\caption{{{escaped(table.caption)}}}", rf"\label{{tab:{table.label}}}"]
    lines += [rf"\begin{{tabular}}{{{columns}}}", r"\toprule", _latex_row(table.headings), r"\midrule"]
    lines += [r"\midrule" if row is None else _latex_row(row) for row in table.rows]
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", r"\end{table}"]) + "\n"


def as_markdown(table: TypesetTable) -> str:
    """Return a table as Markdown, its caption above it."""
    marks = [":--"] * table.texts + ["--:"] * (len(table.headings) - table.texts)
    rows = [table.headings, marks, *(row for row in table.rows if row is not None)]
    body = "\n".join("| " + " | ".join(_in_markdown(cell) for cell in row) + " |" for row in rows)
    return f"{_in_markdown(table.caption)}\n\n{body}\n"


def escaped(text: str) -> str:
    """Return a text that LaTeX sets as it is."""
    return "".join(_SPECIAL.get(letter, letter) for letter in " ".join(text.split()))


def _latex_row(cells: Sequence[str]) -> str:
    return " & ".join(escaped(cell) for cell in cells) + r" \\"


def _in_markdown(text: str) -> str:
    return re.sub(r"([|\\`*_<>])", r"\\\1", " ".join(text.split()))

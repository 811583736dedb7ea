"""`gpsec show`: what a run has found, and any of its tables."""

from pathlib import Path
from typing import Annotated

import typer

from gpsec.console.errors import say
from gpsec.core.errors import GpsecError, nearest, shown

_ALL = "tables"
_WIDTH = 120


def show(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")],
    table: Annotated[
        str | None,
        typer.Argument(metavar="[TABLE]", help="tables (all), costs, or a CSV file of RUN. [default: a few lines]"),
    ] = None,
    rows: Annotated[int, typer.Option("--rows", min=1, metavar="N", help="Of a table as it is in the file.")] = 20,
) -> None:
    """Print what a run has found in a few lines, or one of its tables.

    \b
    Examples:
      gpsec show results/town
      gpsec show results/town tables
      gpsec show results/town safety
      gpsec show results/town events --rows 100
    """  # noqa: D301
    from gpsec.console.aftermath import show_findings
    from gpsec.console.terminal import tables
    from gpsec.outcomes.summary import PARTS, print_summary
    from gpsec.running.results import load

    load(run)  # it is checked before anything of it is shown
    there = sorted(path.stem for path in run.glob("*.csv"))
    if table is None or table == _ALL:
        show_findings(run, table == _ALL)
    elif table in PARTS:
        print_summary(run, tables(_WIDTH), [table])
    elif table in there:
        for line in _plain(run, table, rows, tables(_WIDTH).width):
            say(line)
    else:
        names = [_ALL, *PARTS, *(name for name in there if name not in PARTS)]
        raise GpsecError(f"{run}: no table '{shown(table)}' in this run: {nearest(table, names)}")


def _plain(run: Path, name: str, rows: int, width: int) -> list[str]:
    """Return the first rows of a table as they are in its file, in as many blocks as its columns need."""
    import pandas as pd

    frame = pd.read_csv(run / f"{name}.csv", dtype=str, keep_default_na=False)
    lines = frame.head(rows).to_string(index=False, line_width=width).replace(" \\\n", "\n").splitlines()
    return lines if len(frame) <= rows else [*lines, f"{rows} of {len(frame)} rows; --rows N shows more"]

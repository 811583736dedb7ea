"""Prints what a run cost: SUMO, reading, the security layer, and the slowest stages."""

from collections.abc import Sequence

from rich.console import Console, Group
from rich.table import Table
from rich.text import Text

from gpsec.outcomes.printing import (
    WIDEST_LABEL,
    Manifest,
    caption_line,
    filled_lines,
    fits_console,
    labelled_table,
    number_cell,
    run_name,
    title_line,
)

_STAGES_WIDTH = 40
# Compiling that is not worth a word.
_SHORT_S = 1.0
_COSTS = (
    "SUMO\n(s)",
    "reading\n(s)",
    "security\n(s)",
    "vehicle-\nsteps",
    "peak\nvehicles",
    "SUMO\n(µs)",
    "security\n(µs)",
)


def costs_summary(runs: Sequence[Manifest], console: Console) -> Group:
    """Return the table of what runs cost; where the console is narrow, the slowest stages below it."""
    table = _costs_table(runs, wide=True)
    lines = []
    if not fits_console(table, console):
        table = _costs_table(runs, wide=False)
        lines = ["slowest stages (s)"]
        for run in runs:
            name, *others = _slowest(run) or [""]
            lines.append(filled_lines([f"{run_name(run)}: {name}", *others], console))
    on_road = all("road_steps" in run for run in runs)
    vehicles = "all vehicles, equipped or not" if on_road else "the equipped vehicles"
    caption = (
        f"µs: for every vehicle and step, SUMO's over {vehicles}, security's over the equipped ones; "
        "security: all plans and defences together"
    )
    compiling = [f"{run_name(run)} {run['compile_s']:.1f} s" for run in runs if run.get("compile_s", 0.0) > _SHORT_S]
    if compiling:
        caption += f"; compiling kernels, once, is in none of the figures: {', '.join(compiling)}"
    return Group(title_line("What it cost"), table, *map(Text, lines), caption_line(caption))


def _costs_table(runs: Sequence[Manifest], *, wide: bool) -> Table:
    table = labelled_table("scenario", WIDEST_LABEL)
    for name in _COSTS:
        table.add_column(name, justify="right", no_wrap=True)
    if wide:
        table.add_column("slowest stages\n(s)", overflow="fold", max_width=_STAGES_WIDTH)
    for run in runs:
        sumo_s, security_s = run.get("sumo_s"), sum(run.get("stages_s", {}).values())
        steps: int = run.get("vehicle_steps", 0)
        road_steps: int = run.get("road_steps", steps)
        table.add_row(
            run_name(run),
            number_cell(sumo_s, ".1f"),
            number_cell(run.get("read_s"), ".1f"),
            f"{security_s:.1f}",
            f"{steps:,}",
            f"{run.get('peak_vehicles', 0):,}",
            _microseconds(sumo_s, road_steps),
            _microseconds(security_s, steps),
            *([", ".join(_slowest(run))] if wide else []),
        )
    return table


def _slowest(run: Manifest) -> list[str]:
    stages = sorted(run.get("stages_s", {}).items(), key=lambda item: -item[1])
    return [f"{name} {seconds:.1f}" for name, seconds in stages[:3]]


def _microseconds(seconds: float | None, steps: int) -> str:
    return number_cell(seconds / steps * 1e6 if seconds is not None and steps else None, ".1f")

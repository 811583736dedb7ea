"""`gpsec stress`: one scenario in worlds that filters and detectors do not know."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gpsec.console import options
from gpsec.console.errors import say
from gpsec.core.errors import GpsecError, nearest, shown

if TYPE_CHECKING:
    import pandas as pd

_NARROWEST = 100


def stress(
    scenario: Annotated[
        str, typer.Argument(metavar="SCENARIO", help="A scenario folder, its gpsec.toml, or any .sumocfg.")
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Where table and runs go. [default: results/stress-<scenario>]"),
    ] = None,
    factor: Annotated[
        list[str] | None,
        typer.Option("--factor", metavar="NAME", help="Only this way to differ; can be repeated. [default: all]"),
    ] = None,
    seed: Annotated[int | None, typer.Option(metavar="N", help="Of SUMO and of all noise (seed).")] = None,
    seeds: Annotated[
        str | None,
        typer.Option(metavar="A-B", help="A run for each of these seeds, such as 1-10; they are pooled."),
    ] = None,
    duration: Annotated[float | None, typer.Option(metavar="S", help="Simulated seconds (duration_s).")] = None,
    profile: options.Profile = None,
    set_: options.Set = None,
    part: options.Part = None,
    allow_code: options.AllowCode = False,
    jobs: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Runs at a time. [default: the cores there are]")
    ] = None,
) -> None:
    """Measure what detectors do where noise, map and GNSS are not as they know; goes on where an earlier call stopped.

    \b
    Examples:
      gpsec stress scenarios/sharp_turns
      gpsec stress scenarios/sharp_turns --duration 180 --seeds 1-3
      gpsec stress scenarios/town --factor nothing --factor gnss_2 --set fleet.equipped_share=0.3
    """  # noqa: D301
    from gpsec.core.threads import cores
    from gpsec.paper.runs import RUNS
    from gpsec.paper.stress import FACTORS, run_stress, stressed
    from gpsec.running.folders import resolved
    from gpsec.running.seeds import parse_seeds
    from gpsec.running.workshop import occupied
    from gpsec.scenario import load_scenario
    from gpsec.scenario.outside import Outside
    from gpsec.scenario.overrides import Override

    for name in factor or ():
        if name not in FACTORS:
            raise GpsecError(f"--factor {shown(name)}: unknown factor: {nearest(name, list(FACTORS))}")
    changes = options.changes(set_, profile)
    if seeds is not None and seed is not None:
        raise GpsecError(f"--seeds {seeds}: expected it without --seed")
    flags = {"duration_s": (duration, f"--duration {duration}"), "seed": (seed, f"--seed {seed}")}
    changes += [Override((key,), value, flag) for key, (value, flag) in flags.items() if value is not None]
    found = load_scenario(scenario, changes, Outside(tuple(part or ()), allow_code))
    runs = stressed(found, list(dict.fromkeys(factor or FACTORS)), parse_seeds(seeds) if seeds else [found.seed])
    target = resolved(out or Path("results") / f"stress-{found.name}")
    from gpsec.console.bars import display
    from gpsec.console.terminal import messages
    from gpsec.report.stress_page import write_stress

    console = messages()
    count = sum(len(members) for members in runs.values())
    with (
        occupied(target / RUNS, target),
        display(console, count) as show,
    ):
        table = run_stress(target, runs, jobs or cores(), show)
        made = write_stress(table, found.name, target)
    _show(table)
    say(f"{target}: stress.csv, {', '.join(path.name for path in made)}")


def _show(table: "pd.DataFrame") -> None:
    """Show false alarms and lines touched, one table for each false-alarm rate and one line for each factor."""
    from rich.table import Table

    from gpsec.console.terminal import tables
    from gpsec.paper.stress import is_bound
    from gpsec.report.formatting import figure
    from gpsec.report.stress_page import detector_rate, honest_rows, rates
    from gpsec.types.points import without_rate

    honest = honest_rows(table)
    honest = honest[~honest["detector"].map(is_bound)]
    console = tables(_NARROWEST)
    console.print("False alarms per vehicle-hour, and honest vehicles that touch a line")
    for rate in rates(honest):
        mine = honest[honest["detector"].map(lambda name, wanted=rate: detector_rate(name) == wanted)]
        names = list(dict.fromkeys(mine["detector"]))
        shown_table = Table(f"thresholds at {rate}", *map(without_rate, names), box=None)
        for title, rows in mine.groupby("title", sort=False):
            of = rows.drop_duplicates("detector").set_index("detector")
            cells = []
            for name in names:
                row = of.loc[name]
                touched = "" if row.isna()["line_touched"] else f" ({int(row['line_touched'])})"
                cells.append(figure(row["false_alarms_per_vehicle_hour"]) + touched)
            shown_table.add_row(str(title), *cells)
        console.print(shown_table)

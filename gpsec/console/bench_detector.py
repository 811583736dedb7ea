"""`gpsec bench-detector`: the standard suite for a detector of somebody's, beside those of gpsec."""

from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from gpsec.console import options
from gpsec.console.errors import say

if TYPE_CHECKING:
    import pandas as pd

    from gpsec.paper.entering import Entrant

_NARROWEST = 110
_MOST_LINES = 15


def bench_detector(
    detectors: Annotated[
        list[str],
        typer.Argument(
            metavar="DETECTOR...", help="FILE.py:Name, package.module:Name, or a name of `gpsec list detectors`."
        ),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where runs and leaderboard.csv go.")] = Path(
        "results/bench-detector"
    ),
    profile: Annotated[str, typer.Option(metavar="P", help="Sensor profile of the fleet.")] = "carla",
    quick: Annotated[
        bool, typer.Option("--quick", help="A small suite for a first look; its rows are compared with no others.")
    ] = False,
    jobs: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Processes at a time. [default: the cores]")
    ] = None,
) -> None:
    """Put a detector through the standard suite; goes on where an earlier call stopped.

    The detector is tried (answers, and at most 200 µs a track-step), trained and calibrated on the training networks at
    measured rates of false alarms, and run on others, over several seeds, against attackers who know nothing and
    attackers who know it. leaderboard.csv gets its rows, beside those of gpsec's own detectors.

    \b
    Examples:
      gpsec bench-detector mine.py:OcSvm --quick
      gpsec bench-detector mine.py:OcSvm
      gpsec bench-detector mine.py:OcSvm --profile dsd --out results/mine
      gpsec bench-detector joint cusum
    """  # noqa: D301
    from gpsec.console.bars import display
    from gpsec.console.terminal import messages
    from gpsec.console.train import display_training
    from gpsec.core.threads import cores
    from gpsec.paper.entering import Entrant, check_profile_known, count_runs, entrant_name, qualify, run_suite
    from gpsec.paper.leaderboard import LEADERBOARD, enter, read_leaderboard, reference_leaderboard
    from gpsec.paper.suite import QUICK, STANDARD
    from gpsec.running.folders import resolved
    from gpsec.running.workshop import occupied

    check_profile_known(profile)
    loaded = [options.load_given_parts([one]) if ":" in one else () for one in detectors]
    names = [entrant_name(one, parts[0] if parts else None) for one, parts in zip(detectors, loaded, strict=True)]
    target, suite, console = resolved(out), QUICK if quick else STANDARD, messages()
    entrants = [Entrant(name, parts, profile, suite, target) for name, parts in zip(names, loaded, strict=True)]
    with occupied(target, target):
        read_leaderboard(target / LEADERBOARD if (target / LEADERBOARD).is_file() else reference_leaderboard())
        for entrant in entrants:
            began = perf_counter()
            with display_training(console) as tell:
                cost_us = qualify(entrant, jobs or cores(), tell)
            with display(console, count_runs(entrant)) as show:
                rows = run_suite(entrant, cost_us, jobs or cores(), show)
            table = enter(rows, target)
            _show(entrant, table)
            say(f"{entrant.name}: {cost_us:.1f} µs a track-step; {perf_counter() - began:.0f} s in all")
    say(f"{target / LEADERBOARD}: {len(table)} rows")


def _show(entrant: "Entrant", table: "pd.DataFrame") -> None:
    """Show a line for each attacker at the suite's first rate, with the best of the other detectors beside."""
    from rich.table import Table

    from gpsec.console.terminal import tables
    from gpsec.report.formatting import figure, interval

    rate, unseen = entrant.suite.rates[0], "max_undetected_deviation_median_m"
    alike = (table["suite"] == entrant.suite.name) & (table["profile"] == entrant.profile) & (table["rate"] == rate)
    of_rate = table[alike]
    names = ("attacker", "false alarms/h", "unseen (m), median", "out of lane unseen", "line touched", "best other")
    drawn = Table(*names, box=None, title=f"{entrant.name}, {entrant.profile}, {rate}")
    for row in of_rate[of_rate["detector"] == entrant.name].head(_MOST_LINES - 2).to_dict("records"):
        others = of_rate[(of_rate["detector"] != entrant.name) & (of_rate["world"] == row["world"])]
        others = others[others["attack"] == row["attack"]].dropna(subset=[unseen]).sort_values(unseen)
        best = others.iloc[0] if len(others) else None
        cells = [
            f"{figure(row[name], percent=share)} ({interval(row, name, percent=share)})"
            for name, share in (
                ("false_alarms_per_vehicle_hour", False),
                (unseen, False),
                ("out_of_lane_unseen_share", True),
                ("line_touched_caused_share", True),
            )
        ]
        attacker = row["attack"] if row["world"] == "nothing" else f"{row['attack']}, {row['world']}"
        drawn.add_row(attacker, *cells, "" if best is None else f"{figure(best[unseen])} {best['detector']}")
    tables(_NARROWEST).print(drawn)

"""`gpsec search`: the attack that is worst for one defence."""

from pathlib import Path
from typing import Annotated, Any

import typer

from gpsec.console import options
from gpsec.console.errors import say
from gpsec.core.errors import GpsecError, nearest, shown

_NARROWEST = 100


def search(
    scenario: Annotated[
        str, typer.Argument(metavar="SCENARIO", help="A scenario folder, its gpsec.toml, or any .sumocfg.")
    ],
    attack: Annotated[str, typer.Option(metavar="NAME", help="The attack that is searched (`gpsec list attacks`).")],
    free: Annotated[
        list[str] | None,
        typer.Option(
            "--free", metavar="KEY=LOW:HIGH", help="A parameter and its bounds, or KEY=one,other; repeatable."
        ),
    ] = None,
    fix: Annotated[
        list[str] | None,
        typer.Option("--fix", metavar="KEY=VALUE", help="Another key of the plans, such as duration_s=[30,30]."),
    ] = None,
    defence: Annotated[
        str | None, typer.Option(metavar="NAME", help="One of the scenario's defences. [default: the last]")
    ] = None,
    objective: Annotated[
        str, typer.Option(metavar="NAME", help="out_of_lane, line_touched, or undetected (metres before an alarm).")
    ] = "out_of_lane",
    plans: Annotated[int, typer.Option(min=1, max=100_000, metavar="N", help="That each of two samplers tries.")] = 64,
    together: Annotated[int, typer.Option(min=1, max=256, metavar="N", help="Of them in one simulation.")] = 16,
    held_out: Annotated[
        int, typer.Option(min=1, max=100, metavar="N", help="Seeds of noise, and of traffic, to judge the best on.")
    ] = 4,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Where it goes. [default: results/search-<scenario>]")
    ] = None,
    seed: Annotated[int | None, typer.Option(metavar="N", help="Of SUMO and of all noise (seed).")] = None,
    duration: Annotated[float | None, typer.Option(metavar="S", help="Simulated seconds (duration_s).")] = None,
    profile: options.Profile = None,
    set_: options.Set = None,
    part: options.Part = None,
    allow_code: options.AllowCode = False,
) -> None:
    """Search the parameters with which an attack is worst for a defence; goes on where an earlier call stopped.

    \b
    Examples:
      gpsec search scenarios/sharp_turns --attack constant_bias --free bias_m=0.5:15 --free direction_deg=-180:180
      gpsec search scenarios/town --attack drift --free rate_mps=0.005:0.5 --defence joint+ukf5_rollback --duration 120
      gpsec search scenarios/town --attack adaptive --free level=0.5:1 --free junctions=hold,move --fix target=joint
    """  # noqa: D301
    from gpsec.running.folders import resolved
    from gpsec.running.search import WorstCase, run_search, tasks_of
    from gpsec.running.search_score import OBJECTIVES
    from gpsec.running.search_space import make_space
    from gpsec.running.workshop import occupied
    from gpsec.scenario import load_scenario
    from gpsec.scenario.outside import Outside
    from gpsec.scenario.overrides import Override, parse_set

    if objective not in OBJECTIVES:
        raise GpsecError(f"--objective {shown(objective)}: unknown objective: {nearest(objective, OBJECTIVES)}")
    changes = options.changes(set_, profile)
    flags = {"duration_s": (duration, f"--duration {duration}"), "seed": (seed, f"--seed {seed}")}
    changes += [Override((key,), value, flag) for key, (value, flag) in flags.items() if value is not None]
    found = load_scenario(scenario, changes, Outside(tuple(part or ()), allow_code))
    fixed: dict[str, Any] = {}
    for text in fix or ():
        parsed = parse_set(text)
        fixed[".".join(map(str, parsed.key))] = parsed.value
    space = make_space(attack, tuple(free or ()), {"share": 1.0, **fixed})
    known = {one.name: one for one in found.defences}
    chosen = defence or list(known)[-1]
    if chosen not in known:
        raise GpsecError(f"--defence {shown(chosen)}: the scenario has no such defence: {nearest(chosen, known)}")
    wanted = WorstCase(found, known[chosen], space, objective, plans, together, held_out)
    target = resolved(out or Path("results") / f"search-{found.name}")
    from gpsec.console.bars import display
    from gpsec.console.terminal import messages

    console = messages()
    with (
        occupied(target, target),
        display(console, tasks_of(wanted)) as show,
    ):
        table = run_search(wanted, target, show)
    _show(table)
    say(f"{target}: search.csv, trials.csv")


def _show(table: Any) -> None:
    from rich.table import Table

    from gpsec.console.terminal import tables
    from gpsec.report.formatting import figure, interval

    drawn = Table(
        "plan", "judged on", "vehicles", "out of lane (caused)", "line touched (caused)", "seen", "with", box=None
    )
    for row in table.to_dict("records"):
        cells = [
            f"{figure(row[name], percent=True)} {interval(row, name, percent=True)}"
            for name in ("out_of_lane_caused_share", "line_touched_caused_share", "detected_share")
        ]
        drawn.add_row(row["plan"], row["judged_on"], str(row["n_vehicles"]), *cells, row["parameters"])
    tables(_NARROWEST).print(drawn)

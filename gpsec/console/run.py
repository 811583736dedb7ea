"""`gpsec run`: from scenario arguments to published folders and tables on the terminal."""

import os
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from gpsec.console import options
from gpsec.core.errors import GpsecError, shown

if TYPE_CHECKING:
    from gpsec.console.aftermath import Output
    from gpsec.running.workers import Run
    from gpsec.scenario import Scenario
    from gpsec.scenario.outside import Outside
    from gpsec.scenario.overrides import Override


# Of the closed loop where nothing says otherwise; claims need ten.
_FIRST_LOOK_SEEDS = 3


def run(
    scenarios: options.Scenarios,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="One folder for all scenarios. [default: results/<scenario>]"),
    ] = None,
    seed: Annotated[int | None, typer.Option(metavar="N", help="Of SUMO and of all noise (seed).")] = None,
    seeds: Annotated[
        str | None,
        typer.Option(metavar="A-B", help="A run for each of these seeds, such as 1-10, and tables over all of them."),
    ] = None,
    duration: Annotated[
        float | None, typer.Option(metavar="S", help="Simulated seconds (duration_s). [default: the .sumocfg's]")
    ] = None,
    profile: options.Profile = None,
    set_: options.Set = None,
    part: options.Part = None,
    allow_code: options.AllowCode = False,
    log_steps: Annotated[bool, typer.Option("--log-steps", help="Also write every step to steps.parquet.")] = False,
    log_vehicles: Annotated[
        list[str] | None,
        typer.Option("--log-vehicle", metavar="ID", help="Write steps.parquet for this vehicle only; can be repeated."),
    ] = None,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Write report.html.")] = True,
    tables: Annotated[
        bool, typer.Option("--tables", help="Print all tables; later, `gpsec show DIR tables` does.")
    ] = False,
    format_: Annotated[
        Literal["csv", "parquet"],
        typer.Option("--format", help="With parquet, the large tables are written as Parquet files too."),
    ] = "csv",
    engine: Annotated[
        str | None, typer.Option(metavar="E", help="batched, or reference for small fleets. [default: batched]")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the run that DIR holds.")] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a run that was interrupted: only what is missing is run.")
    ] = False,
    jobs: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Scenarios at a time. [default: the cores there are]")
    ] = None,
    threads: Annotated[int | None, typer.Option(metavar="N", help="Threads of each scenario (threads).")] = None,
    spoofers: Annotated[
        list[str] | None,
        typer.Option(
            "--spoofer",
            metavar="LON,LAT,RADIUS_M[,BEGIN,END,ATTACK]",
            help="A spoofer by the road: attacks (drift unless said) who comes near; can be repeated.",
        ),
    ] = None,
    only_zones: Annotated[
        bool, typer.Option("--only-zones", help="Only attacks at a place: drawn zones, and those of --spoofer.")
    ] = False,
    worst: Annotated[
        Path | None,
        typer.Option("--worst", metavar="DIR", help="Add the worst plan of a `gpsec search`, as the plan `worst`."),
    ] = None,
    rates: Annotated[
        str | None,
        typer.Option("--rates", metavar="R,R", help="Every defence at each of these false-alarm rates: 1/h,0.1/h."),
    ] = None,
    closed_loop: Annotated[
        bool,
        typer.Option("--closed-loop", help="Let vehicles steer by their estimate, in worlds beside benign ones."),
    ] = False,
    inject_false_alarms: Annotated[
        str | None,
        typer.Option(
            "--inject-false-alarms", metavar="A,B", help="In closed loop, false alarms a vehicle-hour: 0,1,5,25."
        ),
    ] = None,
    gui: Annotated[bool, typer.Option("--gui", help="Show the run in sumo-gui; one scenario.")] = False,
    gui_plan: Annotated[
        str | None, typer.Option("--gui-plan", metavar="PLAN", help="The attack that is shown. [default: the first]")
    ] = None,
    gui_defence: Annotated[
        str | None,
        typer.Option("--gui-defence", metavar="D", help="Whose alarms and estimates. [default: the last one]"),
    ] = None,
    gui_delay: Annotated[
        float | None,
        typer.Option(
            "--gui-delay", min=0.0, max=1e4, metavar="MS", help="For a step, from the first attack on. [default: 50]"
        ),
    ] = None,
) -> int:
    """Run scenarios, write tables, and say in a few lines what they show.

    \b
    Examples:
      gpsec run scenarios/town
      gpsec run scenarios/town --duration 120 --seed 7 --profile consumer
      gpsec run scenarios/town --set plans.drift.rate_mps=0.2 --set fleet.equipped_share=0.3
      gpsec run scenarios/town --seeds 1-10 --jobs 2
      gpsec run scenarios/town --spoofer 10.5272,52.2642,60 --only-zones
      gpsec run scenarios/town --rates 1/h,0.1/h,1e-3/sample
      gpsec run scenarios/town --worst results/search-town --seeds 11-15
      gpsec run scenarios/town --closed-loop --seeds 1-10 --set closed_loop.on_alarm=stop
      gpsec run scenarios/town --inject-false-alarms 1,5,25 --seeds 1-10
      gpsec run scenarios/* --out results/all --overwrite
      gpsec run scenarios/* --out results/all --resume
      gpsec run scenarios/town --gui --gui-plan spoofed_quarter --gui-defence lstm_glr+ukf
      gpsec run scenarios/town --closed-loop --gui
      gpsec run somewhere/else.sumocfg --set 'plans=[{attack="drift", share=0.2}]'
      gpsec run scenarios/town --part mine.py:Zigzag --set 'plans=[{attack="zigzag"}]'
    """  # noqa: D301
    from gpsec.console.aftermath import Output
    from gpsec.console.spoofing import with_spoofers
    from gpsec.core.threads import cores
    from gpsec.running.seeds import parse_seeds, with_seeds
    from gpsec.scenario.outside import Outside
    from gpsec.scenario.overrides import Override

    closed_loop = closed_loop or inject_false_alarms is not None
    shown = live_run(scenarios, gui, gui_plan, gui_defence, gui_delay)
    flags = {
        ("seed",): (seed, f"--seed {seed}"),
        ("duration_s",): (duration, f"--duration {duration}"),
        ("engine",): (engine, f"--engine {engine}"),
        ("threads",): (threads, f"--threads {threads}"),
        ("log_steps",): (log_steps or None, "--log-steps"),
        ("log_vehicles",): (log_vehicles or None, "--log-vehicle"),
    }
    changes = options.changes(set_, profile)
    changes += [Override(key, value, flag) for key, (value, flag) in flags.items() if value is not None]
    output = Output(out, overwrite, resume, report, format_ == "parquet", tables)
    found = _read(scenarios, changes, Outside(tuple(part or ()), allow_code))
    if spoofers or only_zones:
        found = [with_spoofers(one, spoofers or (), only_zones=only_zones) for one in found]
    if worst is not None:
        found = _with_worst(found, worst, parse_seeds(seeds) if seeds else ())
    if rates is not None:
        found = [_with_rates(one, rates.split(",")) for one in found]
    if inject_false_alarms is not None:
        injected = _rates(inject_false_alarms)
        found = [_with_false_alarms(one, injected) for one in found]
    if seeds is not None:
        if seed is not None or gui:
            raise GpsecError(f"--seeds {seeds}: expected it without {'--gui' if gui else '--seed'}")
        if not closed_loop:
            found = [one for scenario in found for one in with_seeds(scenario, parse_seeds(seeds))]
    if closed_loop and gui:
        found, shown = _shown_world(found[0], gui_plan, gui_defence, gui_delay)
    elif closed_loop:
        found = [world for one in found for world in _worlds(one, seed, parse_seeds(seeds) if seeds else ())]
    return _run(found, output, jobs or cores(), shown)


def _rates(text: str) -> list[float]:
    """Return the rates of `--inject-false-alarms`.

    Raises:
        GpsecError: they are no numbers.
    """
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise GpsecError(f"--inject-false-alarms: expected numbers such as 0,1,5,25, found '{shown(text)}'") from None


def _with_false_alarms(scenario: "Scenario", rates_per_h: Sequence[float]) -> "Scenario":
    from gpsec.scenario.worlds import with_false_alarms

    return with_false_alarms(scenario, rates_per_h)


def _with_worst(scenarios: "Sequence[Scenario]", folder: Path, seeds: Sequence[int]) -> "list[Scenario]":
    from gpsec.running.worst import read_worst

    found = read_worst(folder)
    return [found.into(scenario, seeds or [scenario.seed]) for scenario in scenarios]


def _with_rates(scenario: "Scenario", rates: Sequence[str]) -> "Scenario":
    from gpsec.scenario.rates import with_rates

    return with_rates(scenario, [rate.strip() for rate in rates])


def _worlds(scenario: "Scenario", seed: int | None, seeds: Sequence[int]) -> "list[Scenario]":
    """Return the worlds of a scenario: with the seeds that are asked for, those of its section, or three."""
    from gpsec.scenario.worlds import with_worlds

    if not seeds and seed is None:
        stated = "seeds" in scenario.closed_loop.model_fields_set
        seeds = range(1, 1 + (scenario.closed_loop.seeds if stated else _FIRST_LOOK_SEEDS))
    return with_worlds(scenario, seeds or [scenario.seed])


def _shown_world(
    scenario: "Scenario", plan: str | None, defence: str | None, delay_ms: float | None
) -> "tuple[list[Scenario], Run]":
    """Return the world that is shown, with its own seed, and what shows it."""
    from gpsec.pipeline.live import DELAY_MS, LiveRun
    from gpsec.scenario.worlds import shown_world

    found = shown_world(scenario, plan, defence)
    world = found.closed_loop.world
    steers = world.defence if world is not None else defence
    return [found], LiveRun(found.plans[0].name, steers, DELAY_MS if delay_ms is None else delay_ms)


def _read(arguments: Sequence[str], overrides: "Sequence[Override]", outside: "Outside") -> "list[Scenario]":
    """Return the scenarios, whose names differ.

    Raises:
        GpsecError: one is not as it should be, or two have one name.
    """
    from gpsec.scenario import load_scenario

    scenarios = [load_scenario(argument, overrides, outside) for argument in arguments]
    seen: dict[str, str] = {}
    for scenario, argument in zip(scenarios, arguments, strict=True):
        if scenario.name in seen:
            raise GpsecError(
                f"{argument}: scenario '{scenario.name}' has the name of {seen[scenario.name]}; "
                "give one of them another `name`, or run them one after the other"
            )
        seen[scenario.name] = argument
    return scenarios


def _run(scenarios: "Sequence[Scenario]", output: "Output", jobs: int, run: "Run | None") -> int:
    """Run the scenarios, at most `jobs` at a time, and return the exit status.

    What has finished is kept when another one fails or the user interrupts. `run` takes the place of the pipeline, as
    in `gpsec.running.workers.run_scenarios`.

    Raises:
        GpsecError: a folder is not as it should be; nothing has been run then.
    """
    from gpsec.console import aftermath
    from gpsec.console.bars import display
    from gpsec.console.terminal import messages
    from gpsec.running.batch import claimed

    console = messages()
    with claimed(output.groups(scenarios), overwrite=output.overwrite, resume=output.resume) as batch:
        if batch.found:
            console.note(f"gpsec: found {batch.found}")
        # What shows the tables takes a while to import; there is time for that now.
        for name in ("gpsec.outcomes.brief", *(["gpsec.report.make"] if output.report else [])):
            Thread(target=import_module, args=(name,)).start()
        with display(console, len(batch.names)) as show:
            outcome = batch.run(jobs, show, run)
        refused = batch.publish(outcome)
        return aftermath.tell(batch, outcome, refused, output, console)


def live_run(
    scenarios: Sequence[str], gui: bool, plan: str | None, defence: str | None, delay_ms: float | None
) -> "Run | None":
    """Return what runs a scenario in sumo-gui, None where nothing is to be shown.

    Raises:
        GpsecError: there is no display, there are several scenarios, or an option needs --gui.
    """
    asked = {"--gui-plan": plan, "--gui-defence": defence, "--gui-delay": delay_ms}
    if not gui:
        for option, value in asked.items():
            if value is not None:
                raise GpsecError(f"{option} {value}: expected --gui with it")
        return None
    if len(scenarios) > 1:
        raise GpsecError(f"--gui: expected one scenario, found {len(scenarios)}; show them one after the other")
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        raise GpsecError("--gui: expected a display for the window of sumo-gui, found none (DISPLAY is not set)")
    from gpsec.pipeline.live import DELAY_MS, LiveRun  # late: it is next to everything

    return LiveRun(plan, defence, DELAY_MS if delay_ms is None else delay_ms)

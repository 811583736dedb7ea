"""`gpsec replay`: real logs through the same attacks, detectors and filters as the fleet."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gpsec.console import options
from gpsec.core.errors import GpsecError

if TYPE_CHECKING:
    from gpsec.console.aftermath import Output
    from gpsec.scenario import Scenario


def replay(
    logs: Annotated[
        list[str],
        typer.Argument(metavar="LOG", help="A segment of comma2k19, a .csv, or SUMO's FCD output (.xml, .xml.gz)."),
    ],
    reader: Annotated[
        str | None,
        typer.Option("--reader", metavar="R", help="comma2k19, csv or fcd, where the name of LOG does not say it."),
    ] = None,
    net: Annotated[
        Path | None, typer.Option("--net", metavar="NET", help="The net that FCD output drove on (.net.xml).")
    ] = None,
    config: Annotated[
        Path | None,
        typer.Option("--config", metavar="TOML", help="A gpsec.toml whose plans, defences and other keys are taken."),
    ] = None,
    copies: Annotated[
        int,
        typer.Option(min=1, max=1000, metavar="N", help="How often a drive takes part, each attacked at another time."),
    ] = 10,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="One folder for all logs. [default: results/<log>]"),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(metavar="N", help="Of attacks, and of sensors that a log has not.")
    ] = None,
    profile: Annotated[
        str, typer.Option("--profile", metavar="P", help="Sensor profile that the log is compared with.")
    ] = "consumer",
    set_: options.Set = None,
    part: options.Part = None,
    allow_code: options.AllowCode = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the run that DIR holds.")] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a run that was interrupted: only what is missing is run.")
    ] = False,
    jobs: Annotated[int | None, typer.Option(min=1, metavar="N", help="Logs at a time. [default: the cores]")] = None,
) -> int:
    """Replay logs: sensors as they were, attacks in the real fixes; tables, errors.csv, a tape and log.html.

    \b
    Examples:
      gpsec replay comma2k19/Chunk_1/some-drive/40
      gpsec replay drive.csv --profile consumer --copies 20 --out results/drive
      gpsec replay drive.csv --config scenarios/town/gpsec.toml --set 'plans=[{attack="drift", share=1.0}]'
      gpsec replay fcd.xml.gz --net town.net.xml --set fleet.equipped_share=0.2
      gpsec replay logs/*.csv --out results/logs --resume
    """  # noqa: D301
    from gpsec.console.aftermath import Output
    from gpsec.core.threads import cores
    from gpsec.replay.prepare import place_order, replay_scenario_of
    from gpsec.scenario.outside import Outside
    from gpsec.scenario.overrides import Override

    changes = options.changes(set_, profile)
    if seed is not None:
        changes.append(Override(("seed",), seed, f"--seed {seed}"))
    outside = Outside(tuple(part or ()), allow_code)
    scenarios: dict[str, Scenario] = {}
    for log in logs:
        found = replay_scenario_of(place_order(Path(log), reader, net, copies), config, changes, outside)
        if found.name in scenarios:
            raise GpsecError(f"{log}: another log is called {found.name}; replay them one after the other")
        scenarios[found.name] = found
    return _run(list(scenarios.values()), Output(out, overwrite, resume, report=True), jobs or cores())


def _run(scenarios: "Sequence[Scenario]", output: "Output", jobs: int) -> int:
    """Replay the scenarios, at most `jobs` at a time, and return the exit status."""
    from gpsec.console import aftermath
    from gpsec.console.bars import display
    from gpsec.console.terminal import messages
    from gpsec.replay.running import replay_log as run
    from gpsec.report.log_page import write_log_page
    from gpsec.running.batch import claimed

    console = messages()
    with claimed(output.groups(scenarios), overwrite=output.overwrite, resume=output.resume) as batch:
        if batch.found:
            console.note(f"gpsec: found {batch.found}")
        with display(console, len(batch.names)) as show:
            outcome = batch.run(jobs, show, run)
        refused = batch.publish(outcome)
        status = aftermath.tell(batch, outcome, refused, output, console)
        for folder in batch.written(outcome):
            if page := write_log_page(folder):
                console.note(f"gpsec: profile against log: {page}")
        return status

"""`gpsec report`: the page of a run, or of two."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from gpsec.console import options
from gpsec.console.errors import say
from gpsec.core.errors import GpsecError
from gpsec.core.system import in_a_sentence


def report(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")],
    other: Annotated[
        Path | None, typer.Argument(metavar="[OTHER]", help="Another run: compare both, vehicle by vehicle.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="The page. [default: RUN/report.html, OTHER/comparison.html]"),
    ] = None,
    again: Annotated[
        bool,
        typer.Option(
            "--again", help="Simulate the vehicles that it shows again, for every step of theirs: runs RUN's scenario."
        ),
    ] = False,
    geojson: Annotated[
        bool,
        typer.Option("--geojson", help="Also write RUN/places.geojson, for QGIS: the map and what happened where."),
    ] = False,
    spreadsheet: Annotated[
        bool,
        typer.Option(
            "--spreadsheet",
            help="Also write RUN/*.spreadsheet.csv: the tables, with ' before what Excel would take for a formula.",
        ),
    ] = False,
    fleet_hours: Annotated[
        float,
        typer.Option(
            "--fleet-hours", min=0.001, metavar="H", help="Hours that a fleet drives a day, for false alarms."
        ),
    ] = 1000.0,
    part: options.Part = None,
    allow_code: options.RunsCode = False,
) -> int:
    """Write the report of a run, or the comparison of two: one HTML file that opens offline.

    \b
    Examples:
      gpsec report results/town
      gpsec report results/town --again --geojson
      gpsec report results/town --fleet-hours 20000
      gpsec report results/before results/after
    """  # noqa: D301
    options.load_given_parts(part)
    if other is not None:
        _compare(run, other, out)
        return 0
    extras = _Extras(again, geojson, spreadsheet, fleet_hours)
    return _report(run, out, extras, allow_code=allow_code)


@dataclass(frozen=True)
class _Extras:
    """What else is asked for: vehicles simulated again, further files, the hours of a fleet."""

    again: bool
    geojson: bool
    spreadsheet: bool
    fleet_hours: float


def _report(
    folder: Path,
    out: Path | None,
    extras: _Extras,
    *,
    allow_code: bool,
) -> int:
    """Write the report of the run in `folder`, and what else is asked for; return the exit status.

    SUMO is run on what the manifest names only with `extras.again`, and code that it names only with `allow_code`: the
    run may be somebody else's. Where that fails, the page is written all the same, and the status says it.

    Raises:
        GpsecError: it is no run, or nothing can be written there.
    """
    from gpsec.console.resimulation import completed
    from gpsec.console.terminal import messages
    from gpsec.report.make import Steps, logged_steps, write_report
    from gpsec.report.map import write_places
    from gpsec.report.stories import choose_stories
    from gpsec.running.results import load, write_spreadsheets

    run = load(folder)
    steps: Steps | None = None
    status = 0
    if extras.again and not run.worlds:  # worlds keep what their page shows
        try:
            stories = choose_stories(run)
            wanted = [(story.scenario, story.vehicle_id) for story in stories]
            steps = completed(run, logged_steps(run, stories), wanted, allow_code=allow_code)
        except GpsecError as error:
            # The report is worth having without them, and says what it lacks.
            messages().note(f"gpsec: no traces: {error}")
            status = error.status
    with in_a_sentence(f"{out or folder}: no report can be written there"):
        written = [write_report(run, steps, out, extras.fleet_hours)]
        if extras.geojson:
            written.append(write_places(run))
        if extras.spreadsheet:
            written += write_spreadsheets(run)
    for path in written:
        say(path)
    return status


def _compare(first: Path, second: Path, out: Path | None) -> None:
    """Write the page that compares two runs.

    Raises:
        GpsecError: one is no run, they have no vehicle in common, or nothing can be written there.
    """
    from gpsec.report.comparison_page import write_comparison
    from gpsec.running.results import load

    runs = load(first), load(second)
    with in_a_sentence(f"{out or second}: no page can be written there"):
        page = write_comparison(*runs, out)
    say(page)

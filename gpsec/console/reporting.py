"""`gpsec report` and `gpsec trace`."""

from pathlib import Path

from gpsec.console.bars import display
from gpsec.console.complaint import say
from gpsec.console.terminal import messages, tables
from gpsec.core.errors import GpsecError, shown
from gpsec.core.system import in_a_sentence
from gpsec.report.comparison_page import write_comparison
from gpsec.report.make import Steps, logged_steps, trace_page, write_report, write_trace
from gpsec.report.map import write_places
from gpsec.report.resimulate import simulate
from gpsec.report.stories import choose_stories, story_of
from gpsec.report.terminal import story_parts
from gpsec.report.traces import rows_of
from gpsec.running.results import Results, load, write_spreadsheets
from gpsec.scenario.outside import load_parts


def report(
    folder: Path,
    out: Path | None,
    *,
    again: bool,
    geojson: bool,
    spreadsheet: bool = False,
    allow_code: bool = False,
) -> int:
    """Write the report of the run in `folder`, and what else is asked for; return the exit status.

    SUMO is run on what the manifest names only with `again`, and code that it names only with `allow_code`: the run may
    be somebody else's. Where that fails, the page is written all the same, and the status says it.

    Raises:
        GpsecError: it is no run, or nothing can be written there.
    """
    run = load(folder)
    stories = choose_stories(run)
    steps: Steps = logged_steps(run, stories)
    status = 0
    if again:
        try:
            _load_code(run, allow_code)
            steps = _completed(run, steps, [(story.scenario, story.vehicle_id) for story in stories])
        except GpsecError as error:
            # The report is worth having without them, and says what it lacks.
            messages().print(f"gpsec: no traces: {error}", markup=False, highlight=False, soft_wrap=True)
            status = error.status
    with in_a_sentence(f"{out or folder}: no report can be written there"):
        written = [write_report(run, steps, out)]
        if geojson:
            written.append(write_places(run))
        if spreadsheet:
            written += write_spreadsheets(run)
    for path in written:
        say(path)
    return status


def compare(first: Path, second: Path, out: Path | None) -> None:
    """Write the page that compares two runs.

    Raises:
        GpsecError: one is no run, they have no vehicle in common, or nothing can be written there.
    """
    runs = load(first), load(second)
    with in_a_sentence(f"{out or second}: no page can be written there"):
        page = write_comparison(*runs, out)
    say(page)


def tell(
    folder: Path,
    vehicle_id: str,
    scenario: str | None,
    attack: str | None,
    out: Path | None,
    *,
    allow_code: bool = False,
) -> None:
    """Tell the story of one vehicle on the terminal, and write it as a page.

    Raises:
        GpsecError: it is no run, there is no such vehicle, or it cannot be simulated again.
    """
    run = load(folder)
    story = story_of(run, vehicle_id, scenario, attack)
    steps: Steps = {story.scenario: run.steps(story.scenario, [vehicle_id])}
    _load_code(run, allow_code)
    steps = _completed(run, steps, [(story.scenario, vehicle_id)])
    logged = steps[story.scenario]
    if logged is None or rows_of(story, logged).empty:
        raise GpsecError(f"{folder}: no steps of vehicle '{shown(vehicle_id)}' could be found")
    console = tables(100)
    for part in story_parts(run, story, rows_of(story, logged)):
        console.print(part, markup=False, highlight=False)
    path = out or folder / trace_page(vehicle_id)
    with in_a_sentence(f"{path}: no page can be written there"):
        page = write_trace(run, story, steps, path)
    say(page)


def _load_code(run: Results, allow_code: bool) -> None:
    """Load the parts from outside gpsec that the manifest names, where the user allows it."""
    for stated in run.scenarios if allow_code else ():
        try:
            load_parts(stated["configuration"].get("parts", []), Path(), allow_code=True)
        except ValueError as error:
            raise GpsecError(f"{run.folder}: {error}") from None


def _completed(run: Results, steps: Steps, wanted: list[tuple[str, str]]) -> Steps:
    """Return `steps` with those of `wanted` (scenario, vehicle) that are missing, simulated again."""
    missing: dict[str, list[str]] = {}
    for scenario, vehicle in dict.fromkeys(wanted):
        logged = steps.get(scenario)
        if logged is None or not (logged["vehicle_id"] == vehicle).any():
            missing.setdefault(scenario, []).append(vehicle)
    # All of a scenario's at once: steps that are put together have to have the same columns.
    missing = {name: [vehicle for scenario, vehicle in dict.fromkeys(wanted) if scenario == name] for name in missing}
    if not missing:
        return steps
    with display(messages(), list(missing)) as show:
        return {**steps, **simulate(run, missing, show)}

"""`gpsec trace`: the story of one vehicle."""

from pathlib import Path
from shlex import quote
from typing import Annotated

import typer

from gpsec.console import options
from gpsec.console.errors import say
from gpsec.core.errors import GpsecError, shown
from gpsec.core.system import in_a_sentence


def trace(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")],
    vehicle: Annotated[
        str | None, typer.Argument(metavar="[VEHICLE]", help="As in vehicles.csv. [default: name the worst five]")
    ] = None,
    scenario: Annotated[str | None, typer.Option(metavar="NAME", help="Where a run has several.")] = None,
    attack: Annotated[
        str | None, typer.Option(metavar="PLAN", help="Which of its attacks, or none. [default: the first]")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="The page. [default: RUN/trace-VEHICLE.html]")
    ] = None,
    part: options.Part = None,
    allow_code: options.RunsCode = False,
) -> None:
    """Tell the story of one vehicle, on the terminal and as a page; it is simulated again if its steps were not logged.

    \b
    Examples:
      gpsec trace results/town
      gpsec trace results/town car12
      gpsec trace results/fleet-eval car12 --scenario town --attack stealth
    """  # noqa: D301
    from gpsec.console.resimulation import completed
    from gpsec.console.terminal import tables
    from gpsec.report.make import Steps, known_steps, logged_steps, trace_page, traced, write_trace
    from gpsec.report.stories import story_of, worst_stories
    from gpsec.report.terminal import story_parts
    from gpsec.report.traces import rows_of
    from gpsec.running.results import load

    options.load_given_parts(part)
    told = load(run)
    if vehicle is None:
        for story in worst_stories(told, scenario):
            asked = f"--scenario {quote(story.scenario)} --attack {quote(story.attack)}"
            say(f"gpsec trace {run} {quote(story.vehicle_id)} {asked}")
        return
    story = story_of(told, vehicle, scenario, attack)
    steps: Steps = logged_steps(told, [story])
    if (vehicle, story.attack) in traced(told).get(story.scenario, ()):
        steps = known_steps(told, [story])
    steps = completed(told, steps, [(story.scenario, vehicle)], allow_code=allow_code)
    logged = steps[story.scenario]
    if logged is None or rows_of(story, logged).empty:
        raise GpsecError(f"{run}: no steps of vehicle '{shown(vehicle)}' could be found")
    console = tables(100)
    for shape in story_parts(told, story, rows_of(story, logged)):
        console.print(shape, markup=False, highlight=False)
    path = out or run / trace_page(vehicle)
    with in_a_sentence(f"{path}: no page can be written there"):
        page = write_trace(told, story, steps, path)
    say(page)

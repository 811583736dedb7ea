"""`gpsec paper`: one bar for all runs, and what came of it."""

from pathlib import Path
from typing import Annotated

import typer

from gpsec.console.errors import say
from gpsec.core import shipped
from gpsec.core.errors import GpsecError


def paper(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where tables and runs go.")] = Path(
        "results/paper"
    ),
    folder: Annotated[
        Path | None, typer.Option("--dir", metavar="DIR", help="Where scenarios are. [default: those of gpsec]")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Short runs and one seed: wide intervals.")] = False,
    jobs: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Runs at a time. [default: the cores there are]")
    ] = None,
) -> None:
    """Re-create the paper's tables and figures, set beside its own numbers; goes on where an earlier call stopped.

    \b
    Examples:
      gpsec paper
      gpsec paper --quick --out /tmp/paper
    """  # noqa: D301
    _make(out, folder or shipped.scenarios(), quick, jobs)


def _make(out: Path, scenarios: Path, quick: bool, jobs: int | None) -> None:
    """Make the tables in `out`.

    Raises:
        GpsecError: the scenarios are not there, one cannot be run, or `out` cannot be written.
        KeyboardInterrupt: the user has had enough; the same call goes on from there.
    """
    from gpsec.console.bars import display
    from gpsec.console.terminal import messages
    from gpsec.core.threads import cores
    from gpsec.paper.command import make
    from gpsec.paper.design import EVALUATION
    from gpsec.paper.runs import RUNS
    from gpsec.paper.studies import Studies
    from gpsec.running.workshop import occupied
    from gpsec.scenario.networks import TRAINING_NETWORKS

    for network in (*TRAINING_NETWORKS, *EVALUATION):
        if not (scenarios / network).is_dir():
            raise GpsecError(f"{scenarios / network}: expected a scenario of gpsec here; leave --dir out")
    console = messages()
    studies = Studies(scenarios, quick)
    with (
        occupied(out / RUNS, out),
        display(console, studies.count) as show,
    ):
        make(out, studies, jobs or cores(), show)
    say(f"{out}: table1.csv to table4.csv, README.md, figures")

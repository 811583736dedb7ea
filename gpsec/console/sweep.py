"""`gpsec sweep`: many runs from one plan, on this machine, on a cluster, or by workers on a disk in common."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gpsec.console import options
from gpsec.console.errors import INTERRUPTED, say
from gpsec.core.errors import GpsecError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from gpsec.console.bars import Display
    from gpsec.sweeps.folder import SweepFolder
    from gpsec.sweeps.points import ListedTask
    from gpsec.sweeps.work import Worked


def sweep(
    plan: Annotated[Path, typer.Argument(metavar="PLAN", help="A plan in TOML, or the folder of a sweep.")],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="The folder of the sweep. [default: results/<plan>]")
    ] = None,
    store: Annotated[
        Path | None,
        typer.Option("--store", metavar="DIR", help="Where runs are kept; sweeps may share it. [default: OUT/store]"),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Runs at a time. [default: the cores there are]")
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Run on Dask: tcp://host:8786, a scheduler file, or local."),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="Only write the list, and say how long it is.")] = False,
    worker: Annotated[
        bool, typer.Option("--worker", help="Only run what is missing of a sweep's folder, beside other workers.")
    ] = False,
    status: Annotated[bool, typer.Option("--status", help="Only say how far a sweep is, and what failed.")] = False,
    failed: Annotated[bool, typer.Option("--failed", help="Run again only what failed.")] = False,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Write report.html.")] = True,
    allow_code: options.AllowCode = False,
) -> int:
    """Run many scenarios, seeds and parameters; what one simulation can serve is simulated once.

    What is made is kept by its content: the same call goes on where it stopped, and a longer plan runs what is new.

    \b
    Examples:
      gpsec sweep plan.toml --list
      gpsec sweep plan.toml --out results/penetration
      gpsec sweep --status results/penetration
      gpsec sweep --failed results/penetration
      gpsec sweep --worker results/penetration
      gpsec sweep plan.toml --scheduler tcp://head:8786
    """  # noqa: D301
    flags = {"--worker": worker, "--status": status, "--list": list_, "--failed": failed}
    asked = [name for name, on in flags.items() if on]
    if len(asked) > 1:
        raise GpsecError(f"{' and '.join(asked)}: expected one of them")
    if scheduler is not None and (worker or status or list_):
        raise GpsecError(f"--scheduler {scheduler}: expected it without {asked[0]}")
    if status:
        return _status(_existing(plan))
    if worker:
        return _work(_existing(plan, allow_code), jobs)
    made = _existing(plan, allow_code) if plan.is_dir() or failed else _listed(plan, out, store, allow_code)
    if list_:
        return 0
    return _run(made, jobs, scheduler, only_failed=failed, report=report)


def _existing(folder: Path, allow_code: bool = False) -> "SweepFolder":
    from gpsec.sweeps.folder import read_folder

    found = read_folder(folder, allow_code=allow_code)
    found.store.check()
    return found


def _listed(plan: Path, out: Path | None, store: Path | None, allow_code: bool) -> "SweepFolder":
    """Write the list of a plan."""
    from gpsec.console.bars import Counted
    from gpsec.console.terminal import messages
    from gpsec.running.folders import resolved
    from gpsec.sweeps.folder import write_list
    from gpsec.sweeps.listing import count_of, listed
    from gpsec.sweeps.plan import read_plan

    read = read_plan(plan)
    folder = resolved(out or Path("results") / plan.stem)
    with Counted(messages()) as counted:
        tell, most = counted.begin("simulations listed, of at most"), count_of(read)

        def told() -> "Iterator[ListedTask]":
            for number, task in enumerate(listed(read, plan, allow_code), start=1):
                tell(number, max(most, number))
                yield task

        made = write_list(folder, told(), read.parameters, store, allow_code=allow_code)
    say(f"{folder}: {len(made.labels)} simulations for {count_of(read)} combinations of scenario, seed and grid")
    return made


def _status(sweep_folder: "SweepFolder") -> int:
    from gpsec.sweeps.state import state_of

    for line in state_of(sweep_folder).lines():
        say(line)
    return 0


def _work(sweep_folder: "SweepFolder", jobs: int | None) -> int:
    """Be a worker; return the exit status."""
    from gpsec.core.threads import cores
    from gpsec.sweeps.work import missing, work_through

    sweep_folder.check_environment()
    wanted = missing(sweep_folder)
    with _display(wanted) as show:
        worked = work_through(sweep_folder, wanted, jobs or cores(), show)
    return _told(sweep_folder, worked)


def _run(
    sweep_folder: "SweepFolder", jobs: int | None, scheduler: str | None, *, only_failed: bool, report: bool
) -> int:
    """Run what is missing, or only what failed; gather all that is there; return the exit status."""
    from gpsec.core.threads import cores
    from gpsec.sweeps.gather import gather_tables
    from gpsec.sweeps.work import failed, forget_failures, missing, work_through

    sweep_folder.check_environment()
    wanted = failed(sweep_folder) if only_failed else missing(sweep_folder)
    forget_failures(sweep_folder, wanted)
    with _display(wanted) as show:
        if scheduler is None:
            worked = work_through(sweep_folder, wanted, jobs or cores(), show)
        else:
            from gpsec.sweeps.on_dask import connected, work_on

            with connected(scheduler, jobs or cores()) as client:
                worked = work_on(client, sweep_folder, wanted, show)
    from gpsec.console.bars import Counted
    from gpsec.console.terminal import messages
    from gpsec.report.sweep_page import write_sweep

    with Counted(messages()) as counted:
        spoilt = gather_tables(sweep_folder, counted.begin("gathering tables"))
        page = write_sweep(sweep_folder.path, counted.begin("report")) if report else None
    for fingerprint in spoilt:
        messages().note(
            f"gpsec: {sweep_folder.labels[fingerprint]}: its tables were not what was written; run it again"
        )
    status = _told(sweep_folder, worked)
    if page is not None:
        say(page)
    return status or (1 if spoilt else 0)


def _display(fingerprints: list[str]) -> "Display":
    from gpsec.console.bars import display
    from gpsec.console.terminal import messages

    return display(messages(), len(fingerprints))


def _told(sweep_folder: "SweepFolder", worked: "Worked") -> int:
    """Say what failed and what is done; return the exit status."""
    from gpsec.console.terminal import messages
    from gpsec.sweeps.state import state_of

    console = messages()
    for line in state_of(sweep_folder).lines():
        console.note(f"gpsec: {line}")
    if worked.interrupted:
        console.note("gpsec: interrupted; what is done is kept, and the same command goes on")
        return INTERRUPTED
    return min((failure.kind.status for failure in worked.failures), default=0)

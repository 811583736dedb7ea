"""`gpsec.sweep`: what `gpsec sweep` does, as a function."""

from pathlib import Path
from typing import TYPE_CHECKING

from gpsec.core.errors import MachineError
from gpsec.core.processes import check_may_start
from gpsec.core.progress import Progress, Report
from gpsec.core.threads import cores
from gpsec.running.folders import resolved
from gpsec.sweeps.folder import write_list
from gpsec.sweeps.gather import gather_tables
from gpsec.sweeps.listing import listed
from gpsec.sweeps.plan import read_plan
from gpsec.sweeps.results import Sweep
from gpsec.sweeps.work import forget_failures, missing, work_through

if TYPE_CHECKING:
    from distributed import Client


def sweep(
    plan: Path | str,
    folder: Path | str,
    *,
    store: Path | str | None = None,
    jobs: int | None = None,
    client: "Client | None" = None,
    allow_code: bool = False,
    report: Report | None = None,
) -> Sweep:
    """Run what is missing of a plan, and return its results; what failed is in `Sweep.tasks`.

    Args:
        plan: a file in TOML.
        folder: of the sweep, new or of an earlier call.
        store: of runs, which sweeps may share; ``folder/store`` where it is not given.
        jobs: runs at a time on this machine; the number of cores where it is not given.
        client: of Dask, whose workers are used instead of this machine.
        allow_code: run the code that a scenario names under `parts`.
        report: called in this process with the progress, several times a second.

    Raises:
        GpsecError: the plan, a scenario or the folder is not as it should be.
        KeyboardInterrupt: the user has had enough; what is done is kept, and the same call goes on.
    """
    check_may_start()
    file = Path(plan)
    read = read_plan(file)
    place = None if store is None else Path(store)
    made = write_list(
        resolved(Path(folder)), listed(read, file, allow_code), read.parameters, place, allow_code=allow_code
    )
    wanted = missing(made)
    forget_failures(made, wanted)
    if client is None:
        worked = work_through(made, wanted, jobs or cores(), report or _ignore)
    else:
        from gpsec.sweeps.on_dask import work_on

        worked = work_on(client, made, wanted, report or _ignore)
    if worked.interrupted:
        raise KeyboardInterrupt
    if gather_tables(made, lambda done, of: None):
        raise MachineError(f"{made.path}: some runs were not what was written; the same call makes them again")
    return Sweep(made)


def _ignore(progress: Progress) -> None:
    return

"""Compiles the kernels before the first run, different ones in several processes at once.

Every process does the same warm-up run, in which kernels are only compiled, each by the process that comes to it first.
Otherwise all scenarios that run at once would compile all of them.
"""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from gpsec.core.caches import can_keep, kernels_folder
from gpsec.core.errors import GpsecError
from gpsec.core.kernels import are_compiled, kept, note_warmup, only_compile
from gpsec.core.processes import SPAWN, ignore_interrupts, redirect_output, start
from gpsec.core.progress import Progress, Report
from gpsec.core.threads import cores
from gpsec.scenario import ALLOW_CODE, Scenario

# With more of them, the largest kernel takes as long as all others together.
_MOST_PROCESSES = 4
# Where a process says what it has compiled or found.
_KEPT = ".kept"


def compile_kernels(scenarios: Sequence[Scenario], work: Path, report: Report) -> None:
    """Compile what the first of the scenarios needs that can be run, unless there is code of this version already.

    Whatever goes wrong is left to the runs, which compile what they do not find. `work` is an existing folder for
    files in the making.

    Raises:
        GpsecError: there is no cache, or it is not safe.
    """
    batched = [scenario for scenario in scenarios if scenario.engine == "batched"]
    if not batched or are_compiled():
        return
    if not can_keep(kernels_folder()):
        note = f"{kernels_folder()} lacks kernels and cannot be written, so every scenario compiles its own"
        report(Progress(batched[0].name, note=note))
        return
    note = "kernels are compiled once, which takes up to half a minute"
    report(Progress(batched[0].name, stage="compiling kernels", note=note))
    # A name of its own each time: `work` may hold what a killed run has left.
    with TemporaryDirectory(prefix=".warmup-", dir=work, ignore_cleanup_errors=True) as folder:
        _compile(batched, Path(folder))


def _compile(batched: Sequence[Scenario], folder: Path) -> None:
    """Warm up in several processes, below the empty `folder`, and note what they compiled."""
    claims = folder / "claims"
    claims.mkdir()
    told = [scenario.model_dump_json() for scenario in batched]
    processes = [
        SPAWN.Process(target=_warm_up, args=(told, folder / str(number), claims), daemon=True)
        for number in range(min(cores(), _MOST_PROCESSES))
    ]
    try:
        for process in processes:
            start(process)
        for process in processes:
            process.join()
    finally:
        with ignore_interrupts():
            for process in processes:
                if process.pid is not None:
                    process.kill()
                    process.join()
    lists = [path.read_text("utf-8").splitlines() for path in folder.glob(f"*/{_KEPT}")]
    if len(lists) == len(processes):
        note_warmup(name for names in lists for name in names)


def _warm_up(told: Sequence[str], folder: Path, claims: Path) -> None:
    """Be one of the processes; the scenarios are told as JSON."""
    folder.mkdir()
    redirect_output(folder / ".log")
    from gpsec.pipeline.warmup_run import warm_up

    only_compile(claims)
    for text in told:
        try:
            scenario = Scenario.model_validate_json(text, context={ALLOW_CODE: True})
            tables = folder / scenario.name
            tables.mkdir()
            warm_up(scenario, tables)
        except GpsecError:
            continue
        (folder / _KEPT).write_text("\n".join(kept()), "utf-8")
        return

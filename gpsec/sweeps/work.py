"""Works through the list of a sweep in local processes, alone or beside other workers."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from gpsec.core.progress import DONE, Progress, Report
from gpsec.running.task_process import Failure, Run
from gpsec.running.warmup import compile_kernels
from gpsec.running.workers import run_tasks
from gpsec.scenario import ALLOW_CODE, Scenario
from gpsec.sweeps.desk import SweepDesk, failure_file, read_failures, run_as_listed
from gpsec.sweeps.folder import SweepFolder

_LOOK_S = 2.0


@dataclass
class Worked:
    """What became of the simulations that were asked for.

    Attributes:
        failures: those that failed.
        interrupted: the user stopped it.
    """

    failures: list[Failure] = field(default_factory=list)
    interrupted: bool = False


def missing(sweep: SweepFolder) -> list[str]:
    """Return the fingerprints of all simulations that are not in the store."""
    return [fingerprint for fingerprint in sweep.labels if not sweep.store.has(fingerprint)]


def failed(sweep: SweepFolder) -> list[str]:
    """Return the fingerprints of the simulations that failed."""
    return [fingerprint for fingerprint in read_failures(sweep) if not sweep.store.has(fingerprint)]


def forget_failures(sweep: SweepFolder, fingerprints: Sequence[str]) -> None:
    """Let simulations be tried again."""
    for fingerprint in fingerprints:
        failure_file(sweep, fingerprint).unlink(missing_ok=True)


def work_through(
    sweep: SweepFolder, fingerprints: Sequence[str], jobs: int, report: Report, run: Run = run_as_listed
) -> Worked:
    """Make what is missing of the given simulations, at most `jobs` at a time, beside whoever else does.

    It ends when each is in the store or has failed: what another worker has claimed is waited for, and taken over where
    that worker is gone.

    Raises:
        UnfitError: this machine has not what the list was made with.
        GpsecError: the disk refuses.
    """
    sweep.store.sweep_up()
    left = [fingerprint for fingerprint in fingerprints if not sweep.store.has(fingerprint)]
    compile_first(sweep, left, report)
    while left:
        desk = SweepDesk(sweep, left)
        if run_tasks(desk, jobs, report, run):
            return Worked(desk.failures, interrupted=True)
        if desk.unfit is not None:
            raise desk.unfit.kind(f"{desk.unfit.scenario}: {desk.unfit.sentence}")
        ours, noted = set(desk.finished), read_failures(sweep)
        for fingerprint in left:
            if fingerprint not in ours and sweep.store.has(fingerprint):
                report(Progress(sweep.labels[fingerprint], stage=DONE))
        left = [each for each in left if not sweep.store.has(each) and each not in noted]
        # What failed and could not be noted is not tried again and again.
        unnoted = {failure.scenario for failure in desk.failures}
        left = [each for each in left if sweep.labels[each] not in unnoted]
        if left and not ours:
            try:
                time.sleep(_LOOK_S)
            except KeyboardInterrupt:
                return Worked(interrupted=True)
    failures = read_failures(sweep)
    return Worked([failures[each] for each in fingerprints if each in failures])


def compile_first(sweep: SweepFolder, fingerprints: Sequence[str], report: Report) -> None:
    """Compile what the first simulation needs, unless that has been done."""
    for fingerprint in fingerprints[:1]:
        task = sweep.tasks(fingerprint)[0]
        try:
            scenario = Scenario.model_validate_json(task.told, context={ALLOW_CODE: sweep.allow_code})
        except ValueError:
            return  # the run says why
        compile_kernels([scenario], sweep.store.path, _named(report, task.label))


def _named(report: Report, label: str) -> Report:
    return lambda progress: report(replace(progress, scenario=label))

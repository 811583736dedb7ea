"""How far a sweep is, by what lies on the disk: whoever works on it."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from gpsec.running.task_process import Failure
from gpsec.sweeps.desk import read_failures
from gpsec.sweeps.folder import SweepFolder
from gpsec.types.constants import MANIFEST

_MOST_FAILURES = 20
# Of runs that are there, as many say how long one takes.
_SAMPLE = 50


@dataclass(frozen=True)
class State:
    """How far a sweep is.

    Attributes:
        folder: of it.
        done, running, waiting: numbers of simulations.
        failed: those that failed, and where their logs are.
        each_s: seconds that one takes, mean of some that are done; None where none is.
    """

    folder: Path
    done: int
    running: int
    waiting: int
    failed: tuple[tuple[Failure, Path], ...]
    each_s: float | None

    def lines(self) -> Iterator[str]:
        """Yield what is to be said."""
        count = self.done + self.running + self.waiting + len(self.failed)
        line = f"{self.folder}: {self.done} of {count} done, {self.running} running, {len(self.failed)} failed"
        if self.waiting + self.running and self.each_s is not None:
            line += f", {(self.waiting + self.running) * self.each_s / 3600.0:.3g} core hours left"
        yield line
        for failure, log in self.failed[:_MOST_FAILURES]:
            yield f"failed: {failure.scenario}: {failure.sentence} ({log})"
        if len(self.failed) > _MOST_FAILURES:
            yield f"failed: {len(self.failed) - _MOST_FAILURES} more, in {self.folder / 'failed'}"
        if self.failed:
            yield f"gpsec sweep --failed {self.folder} runs them again"


def state_of(sweep: SweepFolder) -> State:
    """Return how far a sweep is."""
    failures = read_failures(sweep)
    done, running, failed = [], 0, []
    for fingerprint in sweep.labels:
        if sweep.store.has(fingerprint):
            done.append(fingerprint)
        elif fingerprint in failures:
            failed.append((failures[fingerprint], sweep.log(fingerprint)))
        elif sweep.store.claimed(fingerprint):
            running += 1
    waiting = len(sweep.labels) - len(done) - running - len(failed)
    return State(sweep.path, len(done), running, waiting, tuple(failed), _each_s(sweep, done))


def _each_s(sweep: SweepFolder, done: list[str]) -> float | None:
    """Return the mean seconds of some runs, spread over the list: later ones may be of other scenarios."""
    seconds = []
    for fingerprint in done[:: max(len(done) // _SAMPLE, 1)]:
        try:
            manifest = json.loads((sweep.store.result(fingerprint) / MANIFEST).read_text("utf-8"))
            seconds.append(float(manifest["total_s"]))
        except (OSError, ValueError, LookupError, TypeError):
            continue
    return sum(seconds) / len(seconds) if seconds else None

"""Gives the simulations of a sweep that are missing to whoever runs them, and takes what becomes of them."""

import json
import os
import socket
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from gpsec.core.errors import GpsecError, MachineError
from gpsec.core.progress import Report
from gpsec.outcomes.tables import whole
from gpsec.running.task_process import Failure, Task, UnfitError, pipeline
from gpsec.scenario import Scenario
from gpsec.sweeps.folder import FAILURES, SweepFolder
from gpsec.sweeps.store import Claim


class SweepDesk:
    """The desk of one worker, see `gpsec.running.workers.Desk`.

    A run is claimed when it is taken, so that any number of workers share a list.

    Attributes:
        unfit: why this worker cannot make runs of the list; it is given no more.
        failures: of those that it was given.
    """

    def __init__(self, sweep: SweepFolder, fingerprints: Sequence[str], *, notes: bool = True) -> None:
        """Take what is to be made, of which some may be there or be claimed.

        With `notes`, what fails is noted on the disk, and what others have noted so is not tried.
        """
        self._notes = notes
        self.unfit: Failure | None = None
        self.failures: list[Failure] = []
        self.finished: list[str] = []
        self._sweep = sweep
        self._waiting = list(reversed(fingerprints))
        self._claims: dict[str, Claim] = {}
        self._of_label: dict[str, str] = {}

    def take(self) -> Task | None:
        """Return the next simulation that is missing, and that nobody else has claimed or tried in vain."""
        while self._waiting and self.unfit is None:
            fingerprint = self._waiting.pop()
            store = self._sweep.store
            if store.has(fingerprint) or (self._notes and failure_file(self._sweep, fingerprint).exists()):
                continue
            claim = store.claim(fingerprint)
            if claim is None:
                continue
            if store.has(fingerprint):  # it was published, and its claim given back, while we looked
                claim.release()
                continue
            label = self._sweep.labels[fingerprint]
            self._claims[label], self._of_label[label] = claim, fingerprint
            log = self._sweep.log(fingerprint)
            begin_log(log, label)
            return Task(label, self._sweep.tasks(fingerprint)[0].told, claim.made, log, self._sweep.allow_code)
        return None

    def beat(self) -> None:
        """Show that those which were taken are still at work."""
        for claim in self._claims.values():
            claim.beat()

    def settle(self, task: Task, failure: Failure | None) -> Failure | None:
        """Put a run into the store, or note why there is none."""
        claim, fingerprint = self._claims.pop(task.name), self._of_label.pop(task.name)
        if failure is None:
            try:
                self._sweep.store.publish(claim)
            except GpsecError as error:
                failure = Failure.of(task.name, error)
        else:
            claim.release()
        if failure is None:
            failure_file(self._sweep, fingerprint).unlink(missing_ok=True)
            self.finished.append(fingerprint)
            return None
        if issubclass(failure.kind, UnfitError):
            self.unfit = failure
        else:
            if self._notes:
                note_failure(self._sweep, fingerprint, failure)
            self.failures.append(failure)
        return failure

    def drop(self, task: Task) -> None:
        """Give back a run that was stopped."""
        self._of_label.pop(task.name)
        self._claims.pop(task.name).release()


def run_as_listed(scenario: Scenario, folder: Path, report: Report) -> None:
    """Run a scenario of a list, whose folder is called by the fingerprint that it had there.

    Raises:
        UnfitError: it would come out otherwise here.
    """
    from gpsec.pipeline.fingerprint import environment_digest, fingerprint

    try:
        found = fingerprint(scenario)
    except GpsecError as error:
        raise UnfitError(f"cannot be run on this machine: {error}") from None
    if found != folder.name:
        raise UnfitError(
            f"expected what was listed, found other code, libraries or input on {socket.gethostname()} (gpsec and its "
            f"libraries are {environment_digest()[:12]} there): it would come out otherwise"
        )
    pipeline(scenario, folder, report)


def failure_file(sweep: SweepFolder, fingerprint: str) -> Path:
    """Return where it is noted that a simulation failed."""
    return sweep.path / FAILURES / f"{fingerprint}.json"


def note_failure(sweep: SweepFolder, fingerprint: str, failure: Failure) -> None:
    """Note why a simulation failed, for the list of those that did, and in its log."""
    stated = {
        "fingerprint": fingerprint,
        "label": sweep.labels[fingerprint],
        "sentence": failure.sentence,
        "machine": issubclass(failure.kind, MachineError),
        "host": socket.gethostname(),
    }
    with suppress(OSError):  # the disk that is full is most likely this one; then it is tried again
        with sweep.log(fingerprint).open("a", encoding="utf-8") as log:
            log.write(f"{failure.details}\ngpsec: failed: {failure.sentence}\n")
        with whole(failure_file(sweep, fingerprint)) as partial:
            partial.write_text(json.dumps(stated, indent=1) + "\n", encoding="utf-8")


def read_failures(sweep: SweepFolder) -> dict[str, Failure]:
    """Return fingerprint -> why it failed, of those on the list, in its order."""
    found = {}
    for fingerprint, label in sweep.labels.items():
        try:
            stated = json.loads(failure_file(sweep, fingerprint).read_text("utf-8"))
            kind = MachineError if stated["machine"] else GpsecError
            found[fingerprint] = Failure(label, str(stated["sentence"]), kind=kind)
        except (OSError, ValueError, LookupError, TypeError):
            continue
    return found


def begin_log(log: Path, label: str) -> None:
    """Say in the log of a simulation who begins it."""
    with suppress(OSError), log.open("a", encoding="utf-8") as file:
        when = time.strftime("%Y-%m-%d %H:%M:%S")
        file.write(f"gpsec: {label}: begun {when} by process {os.getpid()} on {socket.gethostname()}\n")

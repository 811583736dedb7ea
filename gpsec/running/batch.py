"""Scenarios and the folders that they end up in: what is missing is run, and what has finished takes its place."""

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from gpsec.core.errors import GpsecError, MachineError
from gpsec.core.processes import ignore_interrupts
from gpsec.core.progress import Report
from gpsec.core.system import in_a_sentence
from gpsec.running.folders import check_output
from gpsec.running.leftovers import found_at_start
from gpsec.running.publishing import publish
from gpsec.running.workers import Outcome, Run, run_scenarios
from gpsec.running.workshop import Workshop, clear, workshops
from gpsec.scenario import Scenario
from gpsec.types.constants import MANIFEST

Groups = Mapping[Path, Sequence[Scenario]]


@dataclass(frozen=True)
class Batch:
    """Scenarios that are to be run, and their folders, from which other runs are kept.

    Attributes:
        groups: absolute folders, and the scenarios whose tables each of them is to hold.
        missing: those of the groups that are to be run, since they are not there already.
        found: what runs that stopped have left, and what becomes of it, in one line; empty where there is nothing.
    """

    groups: Groups
    missing: Groups
    found: str
    _works: Mapping[Path, Workshop]
    _replaces: bool

    @property
    def names(self) -> list[str]:
        """Names of the scenarios that are to be run."""
        return [scenario.name for members in self.missing.values() for scenario in members]

    def run(self, jobs: int, report: Report, run: Run | None = None) -> Outcome:
        """Run what is missing, at most `jobs` scenarios at a time; see `gpsec.running.workers.run_scenarios`."""
        scenarios = [scenario for members in self.missing.values() for scenario in members]
        return run_scenarios(scenarios, self._first.folder, jobs, report, run)

    def publish(self, outcome: Outcome) -> list[GpsecError]:
        """Let what has finished take its place; return what went wrong.

        A scenario whose folder could not be written does not count as finished any more. What is needed to go on is
        kept in a hidden folder beside the first of the folders.
        """
        refused: list[GpsecError] = []
        with ignore_interrupts():
            made = outcome.finished
            for folder, members in self.missing.items():
                try:
                    with in_a_sentence(f"{folder}: cannot be written"):
                        self._publish(folder, members, outcome)
                except GpsecError as error:
                    refused.append(error)
                    names = {scenario.name for scenario in members}
                    outcome.finished = [name for name in outcome.finished if name not in names]
            failed = bool(outcome.failures) or any(isinstance(error, MachineError) for error in refused)
            self._first.kept = bool(made) and (outcome.interrupted or failed)
            if self._first.kept:
                clear(self._first.folder, keep=made)
            for work in self._works.values():
                work.kept = work.kept and work is self._first
        return refused

    def written(self, outcome: Outcome) -> list[Path]:
        """Return the folders that hold a run now: the whole ones, and those with what has finished of them."""
        return [
            folder for folder in self.groups if folder not in self.missing or _finished(self.missing[folder], outcome)
        ]

    @property
    def _first(self) -> Workshop:
        return self._works[next(iter(self.groups))]

    def _publish(self, folder: Path, members: Sequence[Scenario], outcome: Outcome) -> None:
        """Join what has finished of `members` and let it become `folder`."""
        finished = _finished(members, outcome)
        if not finished:
            return
        from gpsec.outcomes.merging import merge
        from gpsec.running.impact import write_impact

        merged = self._works[folder].folder / ".merged"
        merged.mkdir()
        merge([self._first.folder / name for name in finished], merged)
        write_impact(merged)
        missing = [scenario.name for scenario in members if scenario.name not in finished]
        if missing:
            _note_missing(merged / MANIFEST, missing, outcome)
        publish(merged, folder, self._replaces)


@contextmanager
def claimed(groups: Groups, *, overwrite: bool = False, resume: bool = False) -> Iterator[Batch]:
    """Give the batch of some scenarios, and keep other runs from their folders until the end.

    Args:
        groups: absolute folders, and the scenarios of each; all names differ.
        overwrite: a folder may hold another run, which is replaced.
        resume: go on with what a run of the same scenarios has left, and run what is missing only.

    Raises:
        GpsecError: a folder may not be written, another run is at work there, or there is nothing to resume.
    """
    if overwrite and resume:
        raise GpsecError("resume and overwrite: expected one of them: one goes on with a run, the other replaces it")
    with workshops(list(groups)) as works:
        missing = _missing(groups) if resume else groups
        for folder in missing:
            check_output(folder, overwrite or resume)
        found = found_at_start(works, resume=resume)
        for work in works.values():
            work.begin(resume=resume)
        yield Batch(groups, missing, found, works, overwrite or resume)


def _missing(groups: Groups) -> Groups:
    """Return the groups that are not complete, or whose tables are not what was written.

    Raises:
        GpsecError: a folder holds another run, or one that was made from other input.
    """
    from gpsec.outcomes.digests import are_whole
    from gpsec.outcomes.manifests import read_manifest
    from gpsec.pipeline.fingerprint import fingerprint

    missing = {}
    for folder, members in groups.items():
        wanted = {fingerprint(scenario) for scenario in members}
        manifest = read_manifest(folder) or {}
        found = {str(each.get("fingerprint")) for each in manifest.get("scenarios", [])}
        if not found <= wanted:
            raise GpsecError(f"{folder}: holds another run, or one whose input has changed: there is nothing to resume")
        if found != wanted or not are_whole(folder, manifest):
            missing[folder] = members
    return missing


def _finished(members: Sequence[Scenario], outcome: Outcome) -> list[str]:
    return [scenario.name for scenario in members if scenario.name in outcome.finished]


def _note_missing(manifest: Path, missing: Sequence[str], outcome: Outcome) -> None:
    """Say in the manifest which scenarios of the invocation are not in the tables, and why."""
    reasons = {failure.scenario: failure.sentence for failure in outcome.failures}
    content = json.loads(manifest.read_text(encoding="utf-8"))
    content["unfinished"] = [{"scenario": name, "reason": reasons.get(name, "interrupted")} for name in missing]
    manifest.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")

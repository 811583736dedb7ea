"""`gpsec run`: from scenario arguments to published folders and tables on the terminal."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from threading import Thread

from rich.console import Console

from gpsec.console import terminal
from gpsec.console.bars import display
from gpsec.console.complaint import complain
from gpsec.console.folders import check_output, resolved
from gpsec.console.leftovers import found_at_start
from gpsec.console.publishing import publish
from gpsec.console.workshop import Workshop, clear, workshops
from gpsec.core.errors import GpsecError, MachineError
from gpsec.core.processes import ignore_interrupts
from gpsec.core.system import in_a_sentence
from gpsec.core.threads import cores
from gpsec.running.workers import Failure, Outcome, Run, run_scenarios
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.outside import NOTHING, Outside
from gpsec.scenario.overrides import Override
from gpsec.types.constants import MANIFEST

INTERRUPTED = 130


def launch(
    arguments: Sequence[str],
    overrides: Sequence[Override],
    out: Path | None,
    overwrite: bool,
    jobs: int | None,
    run: Run | None = None,
    *,
    outside: Outside = NOTHING,
    resume: bool = False,
    report: bool = True,
    parquet: bool = False,
) -> int:
    """Run the scenarios and return the exit status.

    With `out` all of them end up in that folder, otherwise each in ``results/<name>``. What has finished is kept
    when another one fails or the user interrupts, and `resume` goes on from there.
    With `report`, each folder gets its ``report.html``, and with `parquet` its large tables as Parquet files too.

    Raises:
        GpsecError: a scenario or a folder is not as it should be; nothing has been run then.
    """
    scenarios = [load_scenario(argument, overrides, outside) for argument in arguments]
    _check_names(scenarios, arguments)
    groups = (
        {resolved(out): scenarios}
        if out is not None
        else {resolved(Path("results") / scenario.name): [scenario] for scenario in scenarios}
    )
    messages = terminal.messages()
    with workshops(list(groups)) as works:
        missing = _missing(groups) if resume else groups
        for folder in missing:
            check_output(folder, overwrite or resume)
        if found := found_at_start(works, resume=resume):
            messages.print(f"gpsec: found {found}", markup=False, highlight=False, soft_wrap=True)
        for work in works.values():
            work.begin(resume=resume)
        outcome = _run(missing, works[next(iter(groups))].folder, jobs or cores(), messages, run, report)
        refused = _publish_all(missing, outcome, works, overwrite or resume)
        for failure in outcome.failures:
            _say(failure, messages)
        for error in refused:
            complain(error)
        status = _status(outcome, missing, refused, messages)
        afterwards = [
            _tell(folder, messages, report=report, parquet=parquet)
            for folder in groups
            if folder not in missing or _finished(missing[folder], outcome)
        ]
    return status or _worst(afterwards)


def _worst(statuses: Iterable[int]) -> int:
    """Return the exit status of several: that of a machine that failed comes before that of a user who erred."""
    return min((status for status in statuses if status), default=0)


def _run(
    groups: Mapping[Path, Sequence[Scenario]], work: Path, jobs: int, messages: Console, run: Run | None, report: bool
) -> Outcome:
    scenarios = [scenario for members in groups.values() for scenario in members]
    # What shows the tables takes a while to import; there is time for that now.
    for name in ("gpsec.outcomes.summary", *(["gpsec.report.make"] if report else [])):
        Thread(target=import_module, args=(name,)).start()
    with display(messages, [scenario.name for scenario in scenarios]) as show:
        return run_scenarios(scenarios, work, jobs, show, run)


def _publish_all(
    groups: Mapping[Path, Sequence[Scenario]], outcome: Outcome, works: Mapping[Path, Workshop], overwrite: bool
) -> list[GpsecError]:
    """Publish what has finished; return what went wrong. What is needed to go on is kept in the first workshop."""
    refused: list[GpsecError] = []
    first, *others = works.values()
    with ignore_interrupts():
        made = outcome.finished
        for folder, members in groups.items():
            try:
                with in_a_sentence(f"{folder}: cannot be written"):
                    _publish(folder, members, outcome, first.folder, works[folder].folder / ".merged", overwrite)
            except GpsecError as error:
                refused.append(error)
                _take_back(members, outcome)
        failed = bool(outcome.failures) or any(isinstance(error, MachineError) for error in refused)
        first.kept = bool(made) and (outcome.interrupted or failed)
        if first.kept:
            clear(first.folder, keep=made)
        for work in others:
            work.kept = False
    return refused


def _check_names(scenarios: Sequence[Scenario], arguments: Sequence[str]) -> None:
    seen: dict[str, str] = {}
    for scenario, argument in zip(scenarios, arguments, strict=True):
        if scenario.name in seen:
            raise GpsecError(
                f"{argument}: scenario '{scenario.name}' has the name of {seen[scenario.name]}; "
                "give one of them another `name`, or run them one after the other"
            )
        seen[scenario.name] = argument


def _missing(groups: Mapping[Path, list[Scenario]]) -> dict[Path, list[Scenario]]:
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


def _publish(
    folder: Path, members: Sequence[Scenario], outcome: Outcome, work: Path, merged: Path, overwrite: bool
) -> None:
    """Join what has finished of `members` and let it become `folder`."""
    finished = _finished(members, outcome)
    if not finished:
        return
    from gpsec.outcomes.merging import merge

    merged.mkdir()
    merge([work / name for name in finished], merged)
    missing = [scenario.name for scenario in members if scenario.name not in finished]
    if missing:
        _note_missing(merged / MANIFEST, missing, outcome)
    publish(merged, folder, overwrite)


def _take_back(members: Sequence[Scenario], outcome: Outcome) -> None:
    """Count scenarios whose folder could not be written as not finished."""
    names = {scenario.name for scenario in members}
    outcome.finished = [name for name in outcome.finished if name not in names]


def _note_missing(manifest: Path, missing: Sequence[str], outcome: Outcome) -> None:
    """Say in the manifest which scenarios of the invocation are not in the tables, and why."""
    reasons = {failure.scenario: failure.sentence for failure in outcome.failures}
    content = json.loads(manifest.read_text(encoding="utf-8"))
    content["unfinished"] = [{"scenario": name, "reason": reasons.get(name, "interrupted")} for name in missing]
    manifest.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def _say(failure: Failure, messages: Console) -> None:
    if failure.details:
        messages.print(failure.details.rstrip(), markup=False, highlight=False, soft_wrap=True)
    line = " ".join(f"gpsec: error: scenario '{failure.scenario}': {failure.sentence}".split())
    messages.print(line, markup=False, highlight=False, soft_wrap=True)


def _tell(folder: Path, messages: Console, *, report: bool, parquet: bool) -> int:
    """Show the tables of a run and write what is made of them; return the exit status.

    The results stand already: what goes wrong now does not take them away, nor what else is to be made.
    """
    parts: list[Callable[[], None]] = [lambda: _show(folder)]
    if parquet:
        parts.append(lambda: _write_parquet(folder))
    if report:
        parts.append(lambda: _report(folder, messages))
    found = []
    for part in parts:
        try:
            part()
        except GpsecError as error:
            found.append(complain(error))
    return _worst(found)


def _show(folder: Path) -> None:
    from gpsec.outcomes.summary import print_summary

    # The tables are laid out for this width, also in a file or a pipe.
    with in_a_sentence("the tables cannot be shown"):
        print_summary(folder, terminal.tables(120))


def _write_parquet(folder: Path) -> None:
    from gpsec.running.results import load, write_parquet

    with in_a_sentence(f"{folder}: no Parquet files can be written there"):
        write_parquet(load(folder))


def _report(folder: Path, messages: Console) -> None:
    from gpsec.report.make import write_report
    from gpsec.running.results import load

    with in_a_sentence(f"{folder}: no report can be written there"):
        path = write_report(load(folder))
    messages.print(f"gpsec: report: {path}", markup=False, highlight=False, soft_wrap=True)


def _status(
    outcome: Outcome, groups: Mapping[Path, Sequence[Scenario]], refused: Sequence[GpsecError], messages: Console
) -> int:
    """Say what has been kept of a run that is not complete, and return the exit status."""
    misplaced = any(isinstance(error, MachineError) for error in refused)
    if outcome.interrupted or outcome.failures or misplaced:
        kept = [str(folder) for folder, members in groups.items() if _finished(members, outcome)]
        what = "interrupted" if outcome.interrupted else "not all scenarios finished"
        names = ", ".join(outcome.finished)
        line = f"{names} kept in {', '.join(kept)}; --resume goes on" if kept else "nothing has been written"
        if misplaced:
            what, line = "not all is in its place", "what has been made is kept; --resume goes on"
        messages.print(f"gpsec: {what}; {line}", markup=False, highlight=False, soft_wrap=True)
    if outcome.interrupted:
        return INTERRUPTED
    return _worst([*(failure.kind.status for failure in outcome.failures), *(error.status for error in refused)])

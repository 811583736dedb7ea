"""What `import gpsec` offers: scenarios are read, checked and run, as the command line does it, and nothing is printed.

Every function takes keys of `gpsec.toml` as keywords, such as ``seed=2``. A section is a table of the keys that change,
``fleet={"profile": "dsd"}``; a plan is changed by its name, ``plans={"drift": {"rate_mps": 0.3}}``, and a list replaces
all of them. What the user can get wrong is a `GpsecError` of one sentence; what the machine refuses, and a fault of
SUMO or gpsec, is a `MachineError`, which is one too.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gpsec.core.errors import GpsecError
from gpsec.core.processes import check_may_start
from gpsec.core.progress import Progress, Report
from gpsec.running.batch import claimed
from gpsec.running.checking import Checked, check_scenario
from gpsec.running.folders import resolved
from gpsec.running.results import Results, load
from gpsec.running.seeds import parse_seeds, with_seeds
from gpsec.running.workers import Outcome
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.load import changed
from gpsec.scenario.outside import Outside
from gpsec.scenario.overrides import of_keywords

__all__ = ["check", "read_scenario", "run"]


def read_scenario(scenario: Scenario | Path | str, *, allow_code: bool = False, **overrides: Any) -> Scenario:
    """Return a scenario, read, resolved and validated; it is not looked at whether its files can be run.

    Args:
        scenario: a scenario folder, its `gpsec.toml`, any `.sumocfg`, a name of `gpsec list scenarios`, or a scenario.
        allow_code: run the code that the file names under `parts`; `parts` given as a keyword are always loaded.
        overrides: keys of `gpsec.toml`.

    Raises:
        GpsecError: a file is missing, a key or value is not one that there is, or the file names code.
    """
    changes, outside = of_keywords(overrides), Outside(allow_code=allow_code)
    if isinstance(scenario, Scenario):
        return changed(scenario, changes, outside)
    return load_scenario(scenario, changes, outside)


def check(scenario: Scenario | Path | str, *, allow_code: bool = False, **overrides: Any) -> Checked:
    """Check that a scenario can be run: its keys, its files, its net, and what SUMO says of them without taking a step.

    Args:
        scenario: see `read_scenario`.
        allow_code: see there.
        overrides: keys of `gpsec.toml`.

    Returns:
        What is in it, and what SUMO warns of.

    Raises:
        GpsecError: something of it is wrong.
    """
    check_may_start()
    return check_scenario(read_scenario(scenario, allow_code=allow_code, **overrides))


def run(
    scenario: Scenario | Path | str,
    folder: Path | str,
    *,
    overwrite: bool = False,
    resume: bool = False,
    allow_code: bool = False,
    report: Report | None = None,
    seeds: Sequence[int] | str = (),
    jobs: int = 1,
    **overrides: Any,
) -> Results:
    """Run a scenario into a folder, which has the tables and the manifest that `gpsec run` writes, and return them.

    The scenario has a process of its own, and so has SUMO. A script needs no ``if __name__ == "__main__"`` for that.
    The folder is whole or as it was: it is made beside it, and takes its place when all is there. Nothing is printed;
    notes are in the manifest too. `gpsec.report.make.write_report` makes the page of the results.

    Args:
        scenario: see `read_scenario`.
        folder: of the results; new, empty, or with `overwrite` or `resume` that of a run.
        overwrite: replace the run that the folder holds; what no run wrote, such as notes, stays.
        resume: return what the folder holds if it is whole and would come out the same, and else run.
        allow_code: see `read_scenario`.
        report: called in this process with the progress, several times a second.
        seeds: make a run for each, such as ``range(1, 11)`` or ``"1-10"``; see `Results.over_seeds`.
        jobs: runs at a time.
        overrides: keys of `gpsec.toml`.

    Raises:
        GpsecError: a file, a key or the folder is not as it should be, or another run is at work there.
        MachineError: a disk is full, SUMO has crashed, or gpsec has a fault; its notes have the last output.
        KeyboardInterrupt: the user has had enough; the folder is as it was.
    """
    check_may_start()
    wanted = read_scenario(scenario, allow_code=allow_code, **overrides)
    members = with_seeds(wanted, parse_seeds(seeds) if isinstance(seeds, str) else tuple(seeds))
    out = resolved(Path(folder))
    with claimed({out: members}, overwrite=overwrite, resume=resume) as batch:
        outcome = batch.run(jobs, report or _ignore)
        refused = batch.publish(outcome)
        _raise_first(outcome, refused)
        return load(out)


def _ignore(progress: Progress) -> None:
    return


def _raise_first(outcome: Outcome, refused: list[GpsecError]) -> None:
    """Raise what kept a scenario from being run or published, if anything did."""
    if outcome.interrupted:
        raise KeyboardInterrupt
    for failure in outcome.failures:
        error = failure.kind(f"scenario '{failure.scenario}': {failure.sentence}")
        if failure.details:
            error.add_note(failure.details)
        raise error
    for error in refused:
        raise error

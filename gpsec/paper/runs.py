"""The runs that the tables are made from: run what is missing, find their folders, say what they were."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from gpsec.core.progress import Report
from gpsec.outcomes.tables import whole
from gpsec.paper.design import (
    Group,
    Pinned,
)
from gpsec.paper.pool import BOOTSTRAP
from gpsec.running.workers import Run, run_scenarios
from gpsec.scenario import Scenario
from gpsec.types.constants import MANIFEST

RUNS = "runs"
"""Folder of the runs, below that of the tables."""


def run_missing(
    scenarios: Sequence[Scenario],
    folder: Path,
    jobs: int,
    report: Report,
    run: Run | None = None,
) -> list[Path]:
    """Run every scenario into ``folder/<name>`` unless it is there already; return the folders in their order.

    `run` takes the place of the pipeline, as in `gpsec.running.workers.run_scenarios`.

    What has finished is kept when a run fails or the user interrupts, so that the same call goes on from there.

    Raises:
        GpsecError: a scenario cannot be run.
        KeyboardInterrupt: the user has had enough.
    """
    folder.mkdir(parents=True, exist_ok=True)
    outcome = run_scenarios(scenarios, folder, jobs, report, run)
    if outcome.interrupted:
        raise KeyboardInterrupt
    if outcome.failures:
        failure = outcome.failures[0]
        sentence = f"scenario '{failure.scenario}': {failure.sentence}"
        raise failure.kind(f"{failure.details}\n{sentence}" if failure.details else sentence)
    return [folder / scenario.name for scenario in scenarios]


@dataclass(frozen=True)
class Runs:
    """Folders of the finished runs.

    Attributes:
        pinned: what was chosen on the training networks.
        groups: folders of the runs, by what they are for; see `Studies.groups`.
    """

    pinned: Pinned
    groups: Mapping[Group, Sequence[Path]]

    def of(self, *group: str) -> Sequence[Path]:
        """Return the folders of a group."""
        return self.groups[group]

    def one(self, *group: str) -> Path:
        """Return the folder of a group of one run."""
        (folder,) = self.groups[group]
        return folder


# Of the manifest of each run: what it was, not what it cost.
_KEPT = ("scenario", "seed", "fingerprint", "configuration", "steps", "vehicles", "vehicle_steps")


def write_runs(path: Path, runs: Runs) -> None:
    """Write what was pinned, how intervals were made, and the configuration of every run."""
    stated = {
        folder.name: json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        for folders in runs.groups.values()
        for folder in folders
    }
    first = next(iter(stated.values()))
    content = {
        "gpsec_version": first["gpsec_version"],
        "git_commit": first["git_commit"],
        "python_version": first["python_version"],
        "versions": first["versions"],
        "pinned": {"delta": runs.pinned.delta, "bias_m": runs.pinned.bias_m},
        "bootstrap": {"seed": BOOTSTRAP.seed, "replicates": BOOTSTRAP.replicates, "confidence": BOOTSTRAP.confidence},
        "runs": {name: {key: run[key] for key in _KEPT} for name, run in sorted(stated.items())},
    }
    with whole(path) as partial:
        partial.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")

"""Runs what is missing of a set of scenarios."""

from collections.abc import Sequence
from pathlib import Path

from gpsec.core.progress import Report
from gpsec.running.workers import Run, run_scenarios
from gpsec.scenario import Scenario


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

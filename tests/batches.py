"""Runs `gpsec run` with another run in the place of the real one, for scripts that tests start as processes."""

from collections.abc import Callable

from gpsec import cli
from gpsec.console import aftermath
from gpsec.running import batch, impact


def main_with(run: Callable[..., None], arguments: list[str]) -> int:
    """Return the exit status of gpsec with `arguments`, where `run` stands for each run and nothing is drawn."""
    real = batch.run_scenarios
    batch.run_scenarios = lambda *args: real(*args[:4], run)
    aftermath.show_findings = lambda folder, all_: None
    impact.write_impact = lambda folder: None
    aftermath._report = lambda folder, messages: None
    return cli.main(arguments)

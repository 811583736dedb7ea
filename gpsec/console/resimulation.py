"""Vehicles of a run whose steps were not logged are simulated again, with bars."""

from pathlib import Path

from gpsec.console.bars import display
from gpsec.console.terminal import messages
from gpsec.core.errors import GpsecError
from gpsec.report.make import Steps
from gpsec.report.resimulate import simulate
from gpsec.running.results import Results
from gpsec.scenario.outside import load_parts


def completed(run: Results, steps: Steps, wanted: list[tuple[str, str]], *, allow_code: bool) -> Steps:
    """Return `steps` with those of `wanted` (scenario, vehicle) that are missing, simulated again.

    Code that the manifest names is only run with `allow_code`.

    Raises:
        GpsecError: they cannot be simulated again.
    """
    _load_code(run, allow_code)
    missing: dict[str, list[str]] = {}
    for scenario, vehicle in dict.fromkeys(wanted):
        logged = steps.get(scenario)
        if logged is None or not (logged["vehicle_id"] == vehicle).any():
            missing.setdefault(scenario, []).append(vehicle)
    # All of a scenario's at once: steps that are put together have to have the same columns.
    missing = {name: [vehicle for scenario, vehicle in dict.fromkeys(wanted) if scenario == name] for name in missing}
    if not missing:
        return steps
    with display(messages(), len(missing)) as show:
        return {**steps, **simulate(run, missing, show)}


def _load_code(run: Results, allow_code: bool) -> None:
    """Load the parts from outside gpsec that the manifest names, where the user allows it."""
    for stated in run.scenarios if allow_code else ():
        try:
            load_parts(stated["configuration"].get("parts", []), Path(), allow_code=True)
        except ValueError as error:
            raise GpsecError(f"{run.folder}: {error}") from None

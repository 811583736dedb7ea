"""What a measurement leaves behind: the error table, tapes of each weather, and a figure."""

from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from gpsec.imaging.filming.error_table import SEEN_BY, ErrorRow, figures_of, tape_of, write_errors
from gpsec.imaging.filming.measure import Errors
from gpsec.imaging.filming.profile_figure import draw_profile
from gpsec.types.tapes import write_tape

ALL_SCENARIOS = "all scenarios"


def write_findings(
    measured: Mapping[str, Mapping[str, Sequence[Errors]]], step_s: float, made: Mapping[str, Any], folder: Path
) -> list[ErrorRow]:
    """Write errors.csv, errors.png and a tape for each weather, single and with memory, and return the rows.

    Args:
        measured: scenario -> weather -> the errors of each vehicle.
        step_s: between pictures.
        made: with what it was made, for the provenance of the tapes.
        folder: to write into, which is there.

    Raises:
        GpsecError: something cannot be written.
    """
    weathers = list(dict.fromkeys(chain.from_iterable(measured.values())))
    pooled = {weather: [one for of in measured.values() for one in of[weather]] for weather in weathers}
    parts = dict(measured) | ({ALL_SCENARIOS: pooled} if len(measured) > 1 else {})
    rows = [
        row
        for scenario, of in parts.items()
        for weather in weathers
        for row in figures_of(scenario, weather, of[weather], step_s)
    ]
    write_errors(rows, folder / "errors.csv")
    draw_profile(pooled, step_s, folder / "errors.png")
    for weather in weathers:
        for mode in SEEN_BY:
            condition = weather if mode == "single" else f"{weather}-{mode}"
            said = {**made, "scenarios": list(measured), "weather": weather, "mode": mode}
            tape = tape_of(pooled[weather], mode, condition, step_s, said)
            write_tape(tape, folder / f"rendered-{condition}.npz")
    return rows

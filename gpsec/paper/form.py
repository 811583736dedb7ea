"""Table I in the paper's own form: two attacks by three detectors, its figures above ours."""

from collections.abc import Iterator, Sequence
from dataclasses import astuple

from gpsec.outcomes.paper import detection_like
from gpsec.paper.design import (
    CONSTANT_BIAS,
    SET_UPS,
    STEALTH,
    TABLE_I_DETECTORS,
)
from gpsec.paper.tables import METRICS, WRITTEN, PaperRow, at

_HEADINGS = {"cusum": "CUSUM", "isolation_forest": "isolation forest", "lstm": "LSTM (Eq 10)", "lstm_glr": "LSTM GLR"}


def table_one_form(rows: Sequence[PaperRow]) -> Iterator[str]:
    """Yield the lines of the table: the paper, the paper as written, and the same with the camera's lane."""
    found = {(row.row, row.metric): row.gpsec for row in rows}
    detectors = (*TABLE_I_DETECTORS, "lstm_glr")
    yield "| attack | | " + " | ".join(_HEADINGS[name] for name in detectors) + " |"
    yield "|---|---|" + "---|" * len(detectors)
    for attack in (CONSTANT_BIAS, STEALTH):
        theirs = [detection_like(attack, name) for name in TABLE_I_DETECTORS]
        cells = [_cell(astuple(each)) if each else "" for each in theirs]
        yield f"| {attack} | the paper | " + " | ".join([*cells, ""]) + " |"
        for profile, network in SET_UPS.items():
            set_up = f"{profile} on {network}"
            for label in (at(f"{WRITTEN} / {set_up}", association="nearest"), at(set_up)):
                figures = [[found.get((f"{label} / {attack} / {name}", key)) for key in METRICS] for name in detectors]
                yield f"| | {label} | " + " | ".join(_cell(each) for each in figures) + " |"


def _cell(figures: Sequence[float | None]) -> str:
    """Return precision / recall / F1, delay as the paper has them; nothing where nothing was scored."""
    if all(figure is None for figure in figures):
        return ""
    *shares, delay = figures
    said = " / ".join("–" if share is None else f"{share:.2f}" for share in shares)
    return f"{said}, {'–' if delay is None else f'{delay:.1f} s'}"

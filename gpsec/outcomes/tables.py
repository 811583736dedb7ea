"""Writes the tables of a run; a file that exists is whole."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from gpsec.core.arrays import Ints, Longs
from gpsec.core.geo import Projector
from gpsec.outcomes.aggregates import StatisticCounts, detection_table, localization_table, safety_table
from gpsec.outcomes.bands import bands_table
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.curves import curves_table
from gpsec.outcomes.events import ClosedTracks
from gpsec.outcomes.lanes import association_table
from gpsec.outcomes.places_table import When, places_table
from gpsec.outcomes.records import events_table, vehicles_table
from gpsec.outcomes.street_names import Streets
from gpsec.outcomes.streets import Exposure, streets_table
from gpsec.outcomes.study import Study

TABLES = (
    *("detection", "localization", "safety", "events", "vehicles", "curves", "error_bands", "places", "streets"),
    "association",
)
# Those that grow with the number of vehicles.
LARGE_TABLES = ("events", "vehicles", "places")
# Of a log: figures of its sensors' errors, and the tape of those of its receiver.
LOG_ERRORS, LOG_TAPE = "errors", "gnss.tape.npz"
# Of the closed loop: a row a world, a row a collision, what is kept for the report; and what attacks do to traffic.
WORLD_TABLES, EFFECTS = ("worlds", "collisions", "crashes", "standing", "jams"), "effects"
# Before the name of a table over all seeds of a scenario.
POOLED_PREFIX = "pooled_"
STEP_LOG = "steps.parquet"
# The same of a few attacks, with fewer steps.
TRACES = "traces.parquet"
MAP = "map.geojson"
# A day in steps of 0.1 s takes six digits, a position within a net seven to the centimetre.
FLOAT_FORMAT = "%.9g"
# Rows that are written as text at once.
_ROWS_AT_ONCE = 10_000


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Give a temporary path beside `path`, which takes its name once the block has succeeded."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.partial")
    try:
        yield partial
        os.replace(partial, path)  # noqa: PTH105
    finally:
        partial.unlink(missing_ok=True)


@dataclass(frozen=True)
class Findings:
    """What one run has found.

    Attributes:
        study: names of plans, detectors, defences, profiles.
        tracks: ordered by vehicle and plan.
        histogram: (P, profiles, K, 2, BINS) counts of statistics, of samples not attacked and attacked.
        rises: (profiles, K, BINS), see `histograms.count`.
        bands: (P, profiles, D, 2, …) counts of errors by the second of the attack.
        lanes: (P, profiles, 3, …) counts of steps on the right lane and not.
        streets: names of the lanes.
        exposure: what was driven on each edge.
        origin_s: simulated time of step 0.

    """

    study: Study
    tracks: ClosedTracks
    histogram: Longs
    rises: Longs
    bands: Ints
    lanes: Longs
    streets: Streets
    exposure: Exposure
    origin_s: float


def write_tables(folder: Path, scenario: str, found: Findings, bootstrap: Bootstrap, projector: Projector) -> None:
    """Write the tables of one run of `scenario` into `folder`.

    Rows follow the order of the tracks, and that of plans, detectors and defences in the study.
    """
    study, tracks, histogram, origin_s = found.study, found.tracks, found.histogram, found.origin_s
    counts = StatisticCounts(histogram, found.rises)
    when = When(bootstrap.seed, origin_s)
    makers: dict[str, Callable[[], pd.DataFrame]] = {
        "detection": lambda: detection_table(study, tracks, counts, scenario, bootstrap),
        "localization": lambda: localization_table(study, tracks, scenario, bootstrap),
        "safety": lambda: safety_table(study, tracks, scenario, bootstrap),
        "events": lambda: events_table(study, tracks, found.streets, scenario, bootstrap.seed, origin_s),
        "vehicles": lambda: vehicles_table(study, tracks, scenario, bootstrap.seed),
        "curves": lambda: curves_table(study, tracks, histogram, scenario),
        "error_bands": lambda: bands_table(study, found.bands, scenario),
        "places": lambda: places_table(study, tracks, scenario, when, projector, found.streets),
        "streets": lambda: streets_table(study, tracks, found.streets, found.exposure, scenario),
        "association": lambda: association_table(study, found.lanes, scenario),
    }
    # One at a time: those with a row for every vehicle are large.
    for name, make in makers.items():
        with whole(folder / f"{name}.csv") as partial:
            write_frame(make(), partial)


def write_frame(table: pd.DataFrame, path: Path) -> None:
    """Write one table, some rows at a time: as text it takes several times the memory."""
    with path.open("w", encoding="utf-8", newline="") as file:
        for first in range(0, max(len(table), 1), _ROWS_AT_ONCE):
            part = _as_text(table.iloc[first : first + _ROWS_AT_ONCE])
            part.to_csv(file, index=False, header=first == 0, lineterminator="\n")


def _as_text(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table with its floats written out, which `to_csv` with a format of its own is slower at."""
    floats = [str(name) for name, kind in table.dtypes.items() if kind == np.float64]
    text = {name: [FLOAT_FORMAT % value if value == value else "" for value in table[name].tolist()] for name in floats}
    return table.assign(**{name: pd.Series(column, table.index, object) for name, column in text.items()})


def read_table(folder: Path, name: str) -> pd.DataFrame:
    """Return one of `TABLES` from `folder`; names are texts, and only empty cells are missing."""
    texts = ["scenario", "vehicle_id", "vehicle_type", "profile", "attack", "defence", "detector", "response"]
    texts += ["by", "rate", "threshold_from", "note", "phase", "association"]
    texts += [
        f"{prefix}{column}" for prefix in ("", "start_", "detection_", "departure_") for column in ("edge", "lane")
    ]
    texts += ["plan", "on_alarm", "kind", "other_id", "road"]
    return pd.read_csv(folder / f"{name}.csv", dtype=dict.fromkeys(texts, str), keep_default_na=False, na_values=[""])

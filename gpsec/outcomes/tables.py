"""Writes the tables of a run, and joins those of several; a file that exists is whole."""

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd

from gpsec.arrays import Ints, Longs
from gpsec.errors import GpsecError, shown
from gpsec.geo import Projector
from gpsec.outcomes.aggregates import detection_table, localization_table, safety_table
from gpsec.outcomes.bands import bands_table
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.curves import curves_table
from gpsec.outcomes.events import ClosedTracks
from gpsec.outcomes.places import places_table
from gpsec.outcomes.records import events_table, vehicles_table
from gpsec.outcomes.study import Study

TABLES = ("detection", "localization", "safety", "events", "vehicles", "curves", "error_bands", "places")
# Those that grow with the number of vehicles.
LARGE_TABLES = ("events", "vehicles", "places")
MANIFEST = "manifest.json"
STEPS = "steps.parquet"
MAP = "map.geojson"
# A day in steps of 0.1 s takes six digits, a position within a net seven to the centimetre.
FLOAT_FORMAT = "%.9g"


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


def write_tables(
    folder: Path,
    scenario: str,
    study: Study,
    tracks: ClosedTracks,
    histogram: Longs,
    bands: Ints,
    origin_s: float,
    bootstrap: Bootstrap,
    projector: Projector,
) -> None:
    """Write the tables of one run of `scenario` into `folder`.

    `tracks` are ordered by vehicle and plan; rows follow that order, and the order of plans, detectors and defences
    in `study`. `origin_s` is the simulated time of step 0.
    """
    tables = {
        "detection": detection_table(study, tracks, histogram, scenario, bootstrap),
        "localization": localization_table(study, tracks, scenario, bootstrap),
        "safety": safety_table(study, tracks, scenario, bootstrap.confidence),
        "events": events_table(study, tracks, scenario, bootstrap.seed, origin_s),
        "vehicles": vehicles_table(study, tracks, scenario, bootstrap.seed),
        "curves": curves_table(study, tracks, histogram, scenario),
        "error_bands": bands_table(study, bands, scenario),
        "places": places_table(study, tracks, scenario, bootstrap.seed, origin_s, projector),
    }
    for name, table in tables.items():
        with whole(folder / f"{name}.csv") as partial:
            _as_text(table).to_csv(partial, index=False, lineterminator="\n", encoding="utf-8")


def _as_text(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table with its floats written out, which `to_csv` with a format of its own is slower at."""
    floats = [str(name) for name, kind in table.dtypes.items() if kind == np.float64]
    text = {name: [FLOAT_FORMAT % value if value == value else "" for value in table[name].tolist()] for name in floats}
    return table.assign(**{name: pd.Series(column, table.index, object) for name, column in text.items()})


def read_table(folder: Path, name: str) -> pd.DataFrame:
    """Return one of `TABLES` from `folder`; names are texts, and only empty cells are missing."""
    texts = ("scenario", "vehicle_id", "vehicle_type", "profile", "attack", "defence", "detector", "response", "by")
    return pd.read_csv(folder / f"{name}.csv", dtype=dict.fromkeys(texts, str), keep_default_na=False, na_values=[""])


def merge(folders: list[Path], out: Path) -> None:
    """Join the files of several runs, a folder each, in `out`; the runs follow in the order of their folders' names.

    Tables are concatenated, manifests become a list under "scenarios". Step logs, whose columns differ with the
    detectors, and maps are kept apart as ``steps-<folder>.parquet`` and ``map-<folder>.geojson`` where there is more
    than one run.

    Raises:
        GpsecError: a folder lacks a file, or its columns are not those of the others.

    """
    folders = sorted(folders, key=lambda folder: folder.name)
    for name in TABLES:
        with whole(out / f"{name}.csv") as partial:
            _join([folder / f"{name}.csv" for folder in folders], partial)
    for folder in folders:
        for file in (Path(STEPS), Path(MAP)):
            if (folder / file).exists():
                target = file.name if len(folders) == 1 else f"{file.stem}-{folder.name}{file.suffix}"
                with whole(out / target) as partial:
                    shutil.copyfile(folder / file, partial)
    manifests = [json.loads(_text(folder / MANIFEST)) for folder in folders]
    with whole(out / MANIFEST) as partial:
        partial.write_text(json.dumps({"scenarios": manifests}, indent=2) + "\n", "utf-8")


def _join(sources: list[Path], target: Path) -> None:
    """Write the lines of CSV files with one header one after the other, to the byte."""
    expected = ""
    with target.open("w", encoding="utf-8", newline="") as joined:
        for source in sources:
            header, _, rows = _text(source).partition("\n")
            if not expected:
                expected = header
                joined.write(header + "\n")
            if header != expected:
                raise GpsecError(
                    f"{source}: header expected '{shown(expected)}' as in {sources[0]}, found '{shown(header)}'"
                )
            joined.write(rows)


def _text(path: Path) -> str:
    try:
        return path.read_text("utf-8")
    except OSError as error:
        raise GpsecError(f"{path}: expected a file of a finished run, found none ({error.strerror})") from None

"""Joins the files of several runs into one; a file that exists is whole."""

import json
import shutil
from pathlib import Path

import pandas as pd

from gpsec.core.errors import GpsecError, shown
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.digests import DIGESTS, table_digests
from gpsec.outcomes.effects import effects_table
from gpsec.outcomes.naming import base_name
from gpsec.outcomes.seeds import POOLED, pooled_tables
from gpsec.outcomes.tables import (
    EFFECTS,
    LOG_ERRORS,
    LOG_TAPE,
    MAP,
    POOLED_PREFIX,
    STEP_LOG,
    TABLES,
    TRACES,
    WORLD_TABLES,
    read_table,
    whole,
    write_frame,
)
from gpsec.types.constants import MANIFEST

_BOOTSTRAP = Bootstrap(seed=2026)


def merge(folders: list[Path], out: Path) -> None:
    """Join the files of several runs, a folder each, in `out`; the runs follow in the order of their folders' names.

    Tables are concatenated, manifests become a list under "scenarios", beside the digests of the tables. Step logs
    and traces, whose columns differ with the detectors, maps and tapes are kept apart as ``steps-<folder>.parquet``,
    ``map-<folder>.geojson`` and so on where there is more than one run.

    Raises:
        GpsecError: a folder lacks a file, or its columns are not those of the others.

    """
    folders = sorted(folders, key=lambda folder: folder.name)
    for name in TABLES:
        with whole(out / f"{name}.csv") as partial:
            _join([folder / f"{name}.csv" for folder in folders], partial)
    for name in (LOG_ERRORS, *WORLD_TABLES):
        if some := [folder / f"{name}.csv" for folder in folders if (folder / f"{name}.csv").exists()]:
            with whole(out / f"{name}.csv") as partial:
                _join(some, partial)
    if (out / "worlds.csv").exists():
        with whole(out / f"{EFFECTS}.csv") as partial:
            write_frame(effects_table(read_table(out, "worlds")), partial)
    for folder in folders:
        for file in (Path(STEP_LOG), Path(TRACES), Path(MAP), Path(LOG_TAPE)):
            if (folder / file).exists():
                target = file.name if len(folders) == 1 else f"{file.stem}-{folder.name}{file.suffix}"
                with whole(out / target) as partial:
                    shutil.copyfile(folder / file, partial)
    _write_pooled(out)
    manifests = [json.loads(_text(folder / MANIFEST)) for folder in folders]
    for manifest in manifests:
        manifest.pop(DIGESTS, None)
    with whole(out / MANIFEST) as partial:
        content = {"scenarios": manifests, DIGESTS: table_digests(out)}
        partial.write_text(json.dumps(content, indent=2) + "\n", "utf-8")


def _write_pooled(out: Path) -> None:
    """Write the tables over all seeds, where a scenario was run with several."""
    names = pd.read_csv(out / "safety.csv", usecols=["scenario"], dtype=str)["scenario"].unique()
    if len({base_name(name) for name in names}) == len(names):
        return
    pooled = pooled_tables({name: read_table(out, name) for name in (*POOLED, "events", "vehicles")}, _BOOTSTRAP)
    for name, table in pooled.items():
        with whole(out / f"{POOLED_PREFIX}{name}.csv") as partial:
            write_frame(table, partial)


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
    except FileNotFoundError as error:
        raise GpsecError(f"{path}: expected a file of a finished run, found none ({error.strerror})") from None

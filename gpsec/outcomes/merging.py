"""Joins the files of several runs into one; a file that exists is whole."""

import json
import shutil
from pathlib import Path

from gpsec.core.errors import GpsecError, shown
from gpsec.outcomes.digests import DIGESTS, table_digests
from gpsec.outcomes.tables import MAP, STEP_LOG, TABLES, whole
from gpsec.types.constants import MANIFEST


def merge(folders: list[Path], out: Path) -> None:
    """Join the files of several runs, a folder each, in `out`; the runs follow in the order of their folders' names.

    Tables are concatenated, manifests become a list under "scenarios", beside the digests of the tables. Step logs,
    whose columns differ with the detectors, and maps are kept apart as ``steps-<folder>.parquet`` and
    ``map-<folder>.geojson`` where there is more than one run.

    Raises:
        GpsecError: a folder lacks a file, or its columns are not those of the others.

    """
    folders = sorted(folders, key=lambda folder: folder.name)
    for name in TABLES:
        with whole(out / f"{name}.csv") as partial:
            _join([folder / f"{name}.csv" for folder in folders], partial)
    for folder in folders:
        for file in (Path(STEP_LOG), Path(MAP)):
            if (folder / file).exists():
                target = file.name if len(folders) == 1 else f"{file.stem}-{folder.name}{file.suffix}"
                with whole(out / target) as partial:
                    shutil.copyfile(folder / file, partial)
    manifests = [json.loads(_text(folder / MANIFEST)) for folder in folders]
    for manifest in manifests:
        manifest.pop(DIGESTS, None)
    with whole(out / MANIFEST) as partial:
        content = {"scenarios": manifests, DIGESTS: table_digests(out)}
        partial.write_text(json.dumps(content, indent=2) + "\n", "utf-8")


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

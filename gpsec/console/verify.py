"""`gpsec verify`: whether the tables of a run are still what was written."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from gpsec.console.errors import complain, say
from gpsec.core.errors import GpsecError
from gpsec.types.constants import MANIFEST

NOT_WHOLE = 1


def verify(runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Folders of runs.")]) -> int:
    """Say of every table of a run whether it is still what was written; the exit status is 1 where one is not.

    Tables are the CSV files, logs of steps and maps; pages and Parquet copies are made of them, and not among them.

    \b
    Examples:
      gpsec verify results/town
      gpsec verify results/town results/highway
    """  # noqa: D301
    return _verify(runs)


def _verify(folders: Sequence[Path]) -> int:
    """Print of every table of the runs in `folders` whether it is whole, changed, missing or added.

    Returns 0 where all are whole, 1 where one is not, 2 where a folder holds no run, or one of a version that kept no
    digests; the others are looked at all the same.
    """
    from gpsec.outcomes.digests import WHOLE
    from gpsec.running.workshop import settle

    status = 0
    for folder in folders:
        try:
            settle(folder)
            states = _states(folder)
        except GpsecError as error:
            status = max(status, complain(error))
            continue
        for name, state in states.items():
            say(f"{state:<8} {folder / name}")
            if state != WHOLE:
                status = max(status, NOT_WHOLE)
    return status


def _states(folder: Path) -> dict[str, str]:
    from gpsec.outcomes.digests import compared
    from gpsec.outcomes.manifests import read_manifest, stated_digests

    manifest = read_manifest(folder) if folder.is_dir() else None
    if manifest is None:
        raise GpsecError(f"{folder}: expected the folder of a run, found no {MANIFEST} in it")
    stated = stated_digests(folder, manifest)
    if stated is None:
        raise GpsecError(f"{folder / MANIFEST}: expected the digests of the tables, found a run of an older version")
    return compared(folder, stated)

"""`gpsec verify`: whether the tables of a run are still what was written."""

from collections.abc import Sequence
from pathlib import Path

from gpsec.console.complaint import complain, say
from gpsec.core.errors import GpsecError
from gpsec.outcomes.digests import WHOLE, compared
from gpsec.outcomes.manifests import read_manifest, stated_digests
from gpsec.running.workshop import settle
from gpsec.types.constants import MANIFEST

NOT_WHOLE = 1


def verify(folders: Sequence[Path]) -> int:
    """Print of every table of the runs in `folders` whether it is whole, changed, missing or added.

    Returns 0 where all are whole, 1 where one is not, 2 where a folder holds no run, or one of a version that kept no
    digests; the others are looked at all the same.
    """
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
    manifest = read_manifest(folder) if folder.is_dir() else None
    if manifest is None:
        raise GpsecError(f"{folder}: expected the folder of a run, found no {MANIFEST} in it")
    stated = stated_digests(folder, manifest)
    if stated is None:
        raise GpsecError(f"{folder / MANIFEST}: expected the digests of the tables, found a run of an older version")
    return compared(folder, stated)

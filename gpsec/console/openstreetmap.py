"""`gpsec import` of an extract of OpenStreetMap: a net, and what to know of it."""

from pathlib import Path

from gpsec.console.complaint import say
from gpsec.console.status import status
from gpsec.console.terminal import messages
from gpsec.openstreetmap.importing import ImportedExtract, import_extract

_NOT_CHECKED = (
    "lanes lie where netconvert lays them beside OpenStreetMap's lines, which are the middles of roads: "
    "there is nothing to check them against"
)


def import_osm(map_file: Path, out: Path, left_hand: bool | None, overwrite: bool) -> None:
    """Import an extract and print what came of it.

    Raises:
        GpsecError: the extract or the output cannot be used.
    """
    with status(messages(), f"{map_file.name}: ") as tell:
        done = import_extract(map_file, out, left_hand=left_hand, overwrite=overwrite, tell=tell)
    for line in _verdict(done):
        say(line)


def _verdict(done: ImportedExtract) -> list[str]:
    return [
        f"{done.net_file}: {done.lanes} lanes, {done.length_m / 1000.0:.1f} km of them",
        *(f"  mended: {sentence}" for sentence in done.mended),
        *(f"  note: {sentence}" for sentence in (*done.notes, _NOT_CHECKED)),
        f"  now: gpsec demand {done.net_file}",
    ]

"""Which reader is for which log."""

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.system import in_a_sentence
from gpsec.replay.checks import check_log
from gpsec.replay.columns import read_csv_log
from gpsec.replay.comma2k19 import is_comma2k19, read_comma2k19
from gpsec.replay.log import DriveLog

FCD = "fcd"
_DRIVES: Mapping[str, Callable[[Path], DriveLog]] = {"comma2k19": read_comma2k19, "csv": read_csv_log}
READERS = (*_DRIVES, FCD)
"""By the name that `--reader` takes; the last is of whole traffic, the others are of one drive."""


def choose_reader(log: Path, asked: str | None) -> str:
    """Return the name of the reader of a log.

    Raises:
        GpsecError: there is no such log or reader, or the log does not say what it is.
    """
    if asked is not None and asked not in READERS:
        raise GpsecError(f"--reader {shown(asked)}: unknown reader: {nearest(asked, READERS)}")
    with in_a_sentence(f"{shown(log)}: cannot be read"):
        if not log.exists():
            raise GpsecError(f"{shown(log)}: no such log")
        if asked is not None:
            return asked
        if is_comma2k19(log):
            return "comma2k19"
    names = "".join(log.suffixes[-2:]).lower()
    if log.is_file() and names.endswith(".csv"):
        return "csv"
    if log.is_file() and names.endswith((".xml", ".xml.gz")):
        return FCD
    raise GpsecError(
        f"{shown(log)}: expected a segment of comma2k19, a .csv, or SUMO's FCD output as .xml or .xml.gz; --reader says"
        " what it is where its name does not"
    )


def read_drive(log: Path, reader: str) -> DriveLog:
    """Return a checked log of one drive.

    Raises:
        GpsecError: it cannot be read, or no run can be made of it.
    """
    with in_a_sentence(f"{log}: cannot be read"):
        read = _DRIVES[reader](log)
    check_log(read)
    return read


def content_digest(log: Path) -> str:
    """Return the SHA-256 of a log: of a file, or of the names and contents of a folder.

    Raises:
        GpsecError: it cannot be read.
    """
    digest = hashlib.sha256()
    with in_a_sentence(f"{log}: cannot be read"):
        for path in [log] if log.is_file() else sorted(path for path in log.rglob("*") if path.is_file()):
            digest.update(path.name.encode() + b"\0")
            with path.open("rb") as file:
                digest.update(hashlib.file_digest(file, "sha256").digest())
    return digest.hexdigest()

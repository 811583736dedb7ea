"""Runs netconvert with the options that make a net of an OpenDRIVE map an HD map."""

import re
from dataclasses import dataclass
from pathlib import Path

from gpsec.errors import GpsecError, retold
from gpsec.sumotools import run_program

OPTIONS = (
    "--precision=4",
    "--precision.geo=8",
    "--opendrive.internal-shapes",
    "--no-turnarounds",
    "--offset.disable-normalization",
    "--junctions.limit-turn-speed=3.5",
    "--tls.default-type=actuated",
    "--output.street-names",
)
CURVE_RESOLUTION_M = 1.0
_ORIGINAL_NAMES = "--output.original-names"
_IGNORE_ERRORS = "--ignore-errors"


@dataclass(frozen=True)
class Converted:
    """What netconvert said.

    Attributes:
        warnings: its warnings, one line each.
        ignored: errors that it was made to pass over.
    """

    warnings: tuple[str, ...]
    ignored: tuple[str, ...]


def convert(source: Path, target: Path, map_file: Path) -> Converted:
    """Make the net `target` of the OpenDRIVE file `source`.

    A map that netconvert refuses is tried once more with its errors ignored.

    Raises:
        GpsecError: netconvert refuses it all the same; `map_file` is what the sentence names.
    """
    arguments = [
        f"--opendrive-files={source.name}",
        f"--output-file={target.name}",
        f"--opendrive.curve-resolution={CURVE_RESOLUTION_M:g}",
        *OPTIONS,
        _ORIGINAL_NAMES,
    ]
    first = run_program("netconvert", arguments, source.parent)
    if first.returncode == 0 and target.is_file():
        return Converted(_said(first.stderr, "Warning: "), ())
    errors = _said(first.stderr, "Error: ")
    target.unlink(missing_ok=True)
    second = run_program("netconvert", [*arguments, _IGNORE_ERRORS], source.parent)
    if second.returncode == 0 and target.is_file():
        return Converted(_said(second.stderr, "Warning: "), errors)
    words = "; ".join((errors or _said(second.stderr, "Error: "))[:3]) or "no reason given"
    raise GpsecError(f"{map_file}: netconvert refuses it: {retold(words)}")


def _said(printed: str, kind: str) -> tuple[str, ...]:
    """Return what of one kind was printed; a message may go on over indented lines."""
    lines = re.sub(r"\n +", " ", printed).splitlines()
    return tuple(line.removeprefix(kind).strip().rstrip(".") for line in lines if line.startswith(kind))

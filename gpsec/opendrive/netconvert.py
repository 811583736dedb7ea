"""Runs netconvert with the options that make a net of an OpenDRIVE map an HD map."""

import re
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from subprocess import CompletedProcess

from gpsec.errors import GpsecError, MachineError, retold
from gpsec.processes import ended_early
from gpsec.sumotools import Limits, run_program

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
# A map that netconvert does not bear with one of these is tried without it.
_DISPENSABLE = (
    "--opendrive.internal-shapes",
    "--tls.default-type=actuated",
    "--junctions.limit-turn-speed=3.5",
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
        without: options that it had to be run without.
    """

    warnings: tuple[str, ...]
    ignored: tuple[str, ...]
    without: tuple[str, ...]


def convert(source: Path, target: Path, map_file: Path, limits: Limits | None = None) -> Converted:
    """Make the net `target` of the OpenDRIVE file `source`.

    A map that netconvert refuses is tried again with its errors ignored, then without one of the options that a net
    can do without, and at last without all of them.

    Args:
        source: file to read.
        target: file to write, in the same folder.
        map_file: what the sentences of errors name.
        limits: for all tries together; those of `Limits` where not given.

    Raises:
        GpsecError: netconvert refuses the map all the same.
        MachineError: it takes more time or memory than the limits allow, or crashes.
    """
    allowed = limits or Limits()
    files = f"--opendrive-files={source.name}", f"--output-file={target.name}"
    fixed = *files, f"--opendrive.curve-resolution={CURVE_RESOLUTION_M:g}", _ORIGINAL_NAMES
    until_s = time.monotonic() + allowed.time_s
    tried: list[CompletedProcess[str]] = []
    for without, extra in _tries():
        options = [option for option in (*OPTIONS, *extra) if option not in without]
        left = replace(allowed, time_s=max(until_s - time.monotonic(), 0.0))
        try:
            done = run_program("netconvert", [*fixed, *options], source.parent, left)
        except MachineError as error:
            raise MachineError(f"{map_file}: {error}") from None
        tried.append(done)
        if done.returncode == 0 and target.is_file():
            ignored = next(filter(None, (said(each, "Error: ") for each in tried)), ())
            return Converted(said(done, "Warning: "), ignored, without)
        target.unlink(missing_ok=True)
    raise _refusal(tried[0], map_file)


def _tries() -> Iterator[tuple[tuple[str, ...], tuple[str, ...]]]:
    """Yield what to leave out of the options, and what to add to them."""
    yield (), ()
    yield (), (_IGNORE_ERRORS,)
    for option in _DISPENSABLE:
        yield (option,), (_IGNORE_ERRORS,)
    yield _DISPENSABLE, (_IGNORE_ERRORS,)


def _refusal(done: CompletedProcess[str], map_file: Path) -> GpsecError:
    """Return what to say of the first try, where no other one came to a net."""
    errors = said(done, "Error: ")
    if done.returncode < 0 and not errors:
        return MachineError(f"{map_file}: {ended_early('netconvert', done.returncode, 'a fault of its own')}")
    return GpsecError(f"{map_file}: netconvert refuses it: {'; '.join(errors[:3]) or 'no reason given'}")


def said(done: CompletedProcess[str], kind: str) -> tuple[str, ...]:
    """Return what of one kind a program has printed, fit for a sentence; a message may go on over indented lines."""
    lines = re.sub(r"\n +", " ", done.stderr).splitlines()
    return tuple(retold(line.removeprefix(kind)).rstrip(".") for line in lines if line.startswith(kind))

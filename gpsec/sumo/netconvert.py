"""Runs netconvert within bounds, and without those options that an input does not bear."""

import re
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from subprocess import CompletedProcess

from gpsec.core.errors import GpsecError, MachineError, retold
from gpsec.core.processes import ended_early
from gpsec.sumo.tools import Limits, run_program

_IGNORE_ERRORS = "--ignore-errors"
# An input that names a schema or a DTD, which may be anywhere, is not held against it.
_NO_SCHEMA = "--xml-validation=never"


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

    def notes(self) -> list[str]:
        """Return what a user should know of it, one sentence each."""
        said = []
        if self.ignored:
            such = "; ".join(self.ignored[:2])
            said.append(f"errors that netconvert had to ignore: {len(self.ignored)}, such as: {such}")
        if self.without:
            said.append(f"netconvert does not bear this map with {', '.join(self.without)}, and was run without")
        if self.warnings:
            said.append(f"warnings of netconvert: {len(self.warnings)}, such as: {self.warnings[0]}")
        return said


def convert(
    options: Sequence[str], dispensable: Sequence[str], target: Path, map_file: Path, limits: Limits | None = None
) -> Converted:
    """Let netconvert write the net `target`, in whose folder it runs.

    An input that it refuses is tried again with its errors ignored, then without one of the options that a net can do
    without, and at last without all of them.

    Args:
        options: those for the input, and all that a net needs.
        dispensable: options that a net can do without.
        target: file to write.
        map_file: what the sentences of errors name.
        limits: for all tries together; those of `Limits` where not given.

    Raises:
        GpsecError: netconvert refuses the map all the same.
        MachineError: it takes more time or memory than the limits allow, or crashes.
    """
    allowed = limits or Limits()
    until_s = time.monotonic() + allowed.time_s
    tried: list[CompletedProcess[str]] = []
    for without, extra in _tries(tuple(dispensable)):
        given = [option for option in (*options, *dispensable, *extra) if option not in without]
        left = replace(allowed, time_s=max(until_s - time.monotonic(), 0.0))
        try:
            done = run_program("netconvert", [*given, _NO_SCHEMA, f"--output-file={target.name}"], target.parent, left)
        except MachineError as error:
            raise MachineError(f"{map_file}: {error}") from None
        tried.append(done)
        if done.returncode == 0 and target.is_file():
            ignored = next(filter(None, (_said(each, "Error: ") for each in tried)), ())
            return Converted(_said(done, "Warning: "), ignored, without)
        target.unlink(missing_ok=True)
    raise _refusal(tried[0], map_file)


def _tries(dispensable: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], tuple[str, ...]]]:
    """Yield what to leave out of the options, and what to add to them."""
    yield (), ()
    yield (), (_IGNORE_ERRORS,)
    for option in dispensable:
        yield (option,), (_IGNORE_ERRORS,)
    yield dispensable, (_IGNORE_ERRORS,)


def _refusal(done: CompletedProcess[str], map_file: Path) -> GpsecError:
    """Return what to say of the first try, where no other one came to a net."""
    errors = _said(done, "Error: ")
    if done.returncode < 0 and not errors:
        return MachineError(f"{map_file}: {ended_early('netconvert', done.returncode, 'a fault of its own')}")
    return GpsecError(f"{map_file}: netconvert refuses it: {'; '.join(errors[:3]) or 'no reason given'}")


def _said(done: CompletedProcess[str], kind: str) -> tuple[str, ...]:
    """Return what of one kind netconvert has printed, fit for a sentence; a message may go on over indented lines."""
    lines = re.sub(r"\n +", " ", done.stderr).splitlines()
    return tuple(retold(line.removeprefix(kind)).rstrip(".") for line in lines if line.startswith(kind))

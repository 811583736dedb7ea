"""Errors that are told in one sentence, without a traceback: the user's, exit status 2, and the machine's, 1."""

from collections.abc import Iterable
from difflib import get_close_matches
from typing import ClassVar


class GpsecError(Exception):
    """What is wrong with the input, in one sentence that names the file and the key or row.

    Attributes:
        status: exit status of a command that ends with it.
    """

    status: ClassVar[int] = 2


class MachineError(GpsecError):
    """What went wrong although the input may be right: a full disk, a limit of the system, a crash of SUMO."""

    status: ClassVar[int] = 1


def nearest(name: str, choices: Iterable[str]) -> str:
    """Say which of `choices` the unknown `name` may have been meant to be.

    Returns a clause such as ``did you mean 'drift'? (known: constant_bias, drift)``.
    """
    known = sorted(choices)
    close = get_close_matches(name, known, n=1, cutoff=0.5)
    listed = ", ".join(known)
    return f"did you mean '{close[0]}'? (known: {listed})" if close else f"known: {listed}"

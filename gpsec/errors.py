"""Errors that a user can cause: one sentence each, no traceback, exit status 2."""

from collections.abc import Iterable
from difflib import get_close_matches


class GpsecError(Exception):
    """What is wrong with the input, in one sentence that names the file and the key or row."""


def nearest(name: str, choices: Iterable[str]) -> str:
    """Say which of `choices` the unknown `name` may have been meant to be.

    Returns a clause such as ``did you mean 'drift'? (known: constant_bias, drift)``.
    """
    known = sorted(choices)
    close = get_close_matches(name, known, n=1, cutoff=0.5)
    listed = ", ".join(known)
    return f"did you mean '{close[0]}'? (known: {listed})" if close else f"known: {listed}"

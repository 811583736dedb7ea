"""Errors that are told in one sentence, without a traceback: the user's, exit status 2, and the machine's, 1."""

import re
from collections.abc import Iterable
from difflib import get_close_matches
from typing import ClassVar

# What a sentence echoes at most of a value, and of what another program says.
LONGEST_VALUE = 100
_LONGEST_SPEECH = 1000
_MOST_CHOICES = 50
_LONG_QUOTE = re.compile(rf"'([^']{{{LONGEST_VALUE + 1},}})'")


class GpsecError(Exception):
    """What is wrong with the input, in one sentence that names the file and the key or row.

    Characters that steer a terminal are escaped, whatever file they came from.

    Attributes:
        status: exit status of a command that ends with it.
    """

    status: ClassVar[int] = 2

    def __init__(self, sentence: str) -> None:
        """Take the sentence; line breaks in it become blanks."""
        super().__init__(printable(re.sub(r"\s*\n\s*", " ", sentence)))


class MachineError(GpsecError):
    """What went wrong although the input may be right: a full disk, a limit of the system, a crash of SUMO."""

    status: ClassVar[int] = 1


def printable(text: str) -> str:
    r"""Return `text` with all that does not print (control, bidi, lone surrogates) escaped as ``\x1b``, ``\u202e``."""
    if text.isprintable():
        return text
    return "".join(sign if sign.isprintable() else sign.encode("unicode_escape").decode() for sign in text)


def shown(value: object) -> str:
    """Return a value from a file for a sentence: at most 100 characters, its middle left out, and all printable."""
    text = str(value)
    if len(text) > LONGEST_VALUE:  # whatever is escaped becomes longer only
        text = f"{text[:LONGEST_VALUE]}…{text[-LONGEST_VALUE:]}"
    text = printable(text)
    return text if len(text) <= LONGEST_VALUE else f"{text[:60]}…{text[61 - LONGEST_VALUE :]}"


def retold(words: str) -> str:
    """Return what another program says of the input, long values in quotes and the whole cut short."""
    short = printable(_LONG_QUOTE.sub(lambda found: f"'{shown(found[1])}'", " ".join(words.split())))
    return short if len(short) <= _LONGEST_SPEECH else f"{short[:_LONGEST_SPEECH]}…"


def nearest(name: str, choices: Iterable[str]) -> str:
    """Say which of `choices` the unknown `name` may have been meant to be.

    Returns a clause such as ``did you mean 'drift'? (known: constant_bias, drift)``.
    """
    known = sorted(choices)
    close = get_close_matches(name[: 10 * LONGEST_VALUE], known, n=1, cutoff=0.5)
    listed = ", ".join(map(shown, known[:_MOST_CHOICES])) + (", …" if len(known) > _MOST_CHOICES else "")
    return f"did you mean '{shown(close[0])}'? (known: {listed})" if close else f"known: {listed}"

"""Single lines for the user; nothing in them steers the terminal, whatever file it came from."""

import sys
from contextlib import suppress

from gpsec.core.errors import GpsecError, printable
from gpsec.core.system import in_a_sentence

INTERRUPTED = 130
"""Exit status after Ctrl-C, as shells have it."""


def say(line: object) -> None:
    """Print one line of an answer."""
    with in_a_sentence("standard output cannot be written"):
        print(printable(str(line)))


def complain(error: GpsecError) -> int:
    """Print what is wrong, in one line, and return the exit status for it."""
    with suppress(OSError):  # where that is full too, the exit status says it
        print(f"gpsec: error: {printable(' '.join(str(error).split()))}", file=sys.stderr)
    return error.status

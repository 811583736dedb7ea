"""Single lines for the user; nothing in them steers the terminal, whatever file it came from."""

import sys

from gpsec.errors import GpsecError, printable


def say(line: object) -> None:
    """Print one line of an answer."""
    print(printable(str(line)))


def complain(error: GpsecError) -> int:
    """Print what is wrong, in one line, and return the exit status for it."""
    print(f"gpsec: error: {printable(' '.join(str(error).split()))}", file=sys.stderr)
    return error.status

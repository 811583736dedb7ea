"""What a user is told who has made a mistake, or whose machine has failed."""

import sys

from gpsec.errors import GpsecError


def complain(error: GpsecError) -> int:
    """Print what is wrong, in one line, and return the exit status for it."""
    print(f"gpsec: error: {' '.join(str(error).split())}", file=sys.stderr)
    return error.status

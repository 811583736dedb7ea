"""What a user is told who has made a mistake."""

import sys

USER_ERROR = 2


def complain(sentence: str) -> int:
    """Print what is wrong, in one line, and return the exit status for it."""
    print(f"gpsec: error: {' '.join(sentence.split())}", file=sys.stderr)
    return USER_ERROR

"""The entry point. Every process that is spawned imports it again, so it imports next to nothing."""

import errno
import os
import signal
import sys
from pathlib import Path
from types import FrameType

from gpsec.console.complaint import complain
from gpsec.errors import GpsecError, shown

INTERRUPTED = 130


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status: 0, 1 for a fault of gpsec, 2 for an error of the user."""
    given = sys.argv[1:] if arguments is None else arguments
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:  # as under nohup
            signal.signal(number, _as_interrupt)
    try:
        Path.cwd()
    except FileNotFoundError:
        return complain(GpsecError("the current folder is gone; go to another one"))
    try:
        from gpsec.console.commands import answer

        return answer(given or ["--help"])
    except GpsecError as error:
        return complain(error)
    except BrokenPipeError:
        # Whoever read our output, such as `head`, has had enough; what is left has nowhere to go.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        if error.errno != errno.ENAMETOOLONG:
            raise
        return complain(GpsecError(f"{shown(error.filename)}: cannot be used as a path: {error.strerror}"))
    except KeyboardInterrupt:
        return INTERRUPTED


def _as_interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt

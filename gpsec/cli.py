"""The entry point. Every process that is spawned imports it again, so it imports next to nothing."""

import os
import signal
import sys
from contextlib import suppress
from pathlib import Path
from types import FrameType

from gpsec.console.errors import INTERRUPTED, complain
from gpsec.core.errors import GpsecError, shown
from gpsec.core.system import refusal


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status: 0, 1 for a fault of gpsec, 2 for an error of the user."""
    given = sys.argv[1:] if arguments is None else arguments
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:  # as under nohup
            signal.signal(number, _as_interrupt)
    # Without an output (as after `>&-`) the first file that is opened would be taken for it.
    sys.stdout = sys.stdout or Path(os.devnull).open("w")  # noqa: SIM115
    sys.stderr = sys.stderr or Path(os.devnull).open("w")  # noqa: SIM115
    try:
        Path.cwd()
    except FileNotFoundError:
        return complain(GpsecError("the current folder is gone; go to another one"))
    try:
        from gpsec.console.commands import answer

        return _delivered(answer(given or ["--help"]))
    except GpsecError as error:
        return complain(error)
    except OSError as error:
        what = f"{shown(error.filename)}: cannot be used" if error.filename else "this cannot be done"
        # What a broken or full output has not taken is still in our hands.
        return _delivered(0) or (0 if isinstance(error, BrokenPipeError) else complain(refusal(error, what)))
    except KeyboardInterrupt:
        return INTERRUPTED


def _delivered(status: int) -> int:
    """Let what was printed reach its reader; return the exit status, which is another where it cannot."""
    try:
        sys.stdout.flush()
    except OSError as error:
        with suppress(OSError):  # otherwise it would be tried again at the end
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):  # whoever read it, such as `head`, has had enough
            return status
        return complain(refusal(error, "standard output cannot be written"))
    return status


def _as_interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt

"""Catches what SUMO prints on the process's standard error."""

import os
import sys
import tempfile
from types import TracebackType
from typing import Self

_STDERR = 2


class CaughtStderr:
    """Context manager that sends file descriptor 2 into a temporary file; `text` gives what came.

    SUMO's error log is not flushed when libsumo raises, so that its words are found here alone. libsumo holds
    the GIL, so that no other thread prints meanwhile.
    """

    def __init__(self) -> None:
        self._file = tempfile.TemporaryFile()  # noqa: SIM115
        self._saved = -1

    def __enter__(self) -> Self:
        if sys.stderr is not None:
            sys.stderr.flush()
        self._saved = os.dup(_STDERR)
        os.dup2(self._file.fileno(), _STDERR)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        os.dup2(self._saved, _STDERR)
        os.close(self._saved)

    def text(self) -> str:
        """Return what was printed since the last call."""
        self._file.seek(0)
        text = self._file.read().decode(errors="replace")
        self._file.seek(0)
        self._file.truncate()
        return text

    def close(self) -> None:
        """Let go of the file."""
        self._file.close()


def sumo_words(printed: str, raised: str) -> str:
    """Return in one line what SUMO complains about, from what it `printed` and the exception that it `raised`.

    The exception often says no more than "Process Error"; the words are then on standard error, where one
    message may go over several lines (file, line and column).
    """
    messages: list[str] = []
    for line in printed.splitlines():
        if line.startswith("Error: "):
            messages.append(line.removeprefix("Error: ").strip())
        elif messages and line.startswith(" "):
            messages[-1] += " " + line.strip()
    if raised not in ("", "Process Error"):
        messages.append(" ".join(raised.split()))
    unique = list(dict.fromkeys(message.rstrip(".") for message in messages if message))
    return "; ".join(unique[:3]) or raised or "no reason given"

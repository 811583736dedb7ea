"""Catches what SUMO prints on the process's standard error, and makes sentences of it and of its error log."""

import os
import re
import sys
import tempfile
from collections.abc import Iterable
from types import TracebackType
from typing import Self

from gpsec.core.errors import retold

_STDERR = 2
# What happens in traffic has a time in SUMO's words; what is said without one is about the input.
_IN_TRAFFIC = "time="
_TOTAL = re.compile(r"(\d+) total messages of type: (.*)")
_NAMES_AND_NUMBERS = re.compile(r"'[^']*'|-?\d+(\.\d+)?|%")
_MOST_KINDS = 10


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


def input_warnings(log: Iterable[str]) -> list[str]:
    """Return what SUMO complains about in its input, a sentence a kind of warning, from the lines of its error log."""
    first: dict[str, str] = {}
    count: dict[str, int] = {}
    for message in _messages(log):
        if _IN_TRAFFIC in message:
            continue
        total = _TOTAL.match(message)
        kind = _NAMES_AND_NUMBERS.sub("%", total[2] if total else message).rstrip(".")
        if total:
            count[kind] = int(total[1])
        else:
            first.setdefault(kind, message)
            count[kind] = count.get(kind, 0) + 1
    said = [
        retold(words.rstrip(".")) + (f" ({count[kind]} of this kind)" if count[kind] > 1 else "")
        for kind, words in first.items()
    ]
    more = [f"{len(said) - _MOST_KINDS} more kinds of warnings are in manifest.json"] if len(said) > _MOST_KINDS else []
    return [f"SUMO warns: {words}" for words in said[:_MOST_KINDS]] + more


def _messages(log: Iterable[str]) -> list[str]:
    """Return the messages in a log, of which one may go over several lines."""
    messages: list[str] = []
    for line in log:
        if line.startswith(("Warning: ", "Error: ")) or not messages:
            messages.append(line.partition(": ")[2].strip())
        else:
            messages[-1] += " " + line.strip()
    return [message for message in messages if message]

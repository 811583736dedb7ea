"""Whole processes: how long they take, and on how many processors at once."""

import os
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from benchmarks.city import ROOT


class RunFailedError(Exception):
    """A process that is measured has failed; its last words are the message."""


@dataclass(frozen=True)
class Usage:
    """What a process took, together with all processes below it.

    Attributes:
        wall_s: from its start to its end.
        cpu_s: user and system.
        output: what it printed.

    """

    wall_s: float
    cpu_s: float
    output: str


def measure(command: Sequence[str], log: Path, environment: Mapping[str, str] | None = None) -> Usage:
    """Run `command` in the root of the project to its end; it prints into the file `log`.

    Raises:
        RunFailedError: its exit status is not 0.

    """
    with log.open("w") as stream:
        began = perf_counter()
        process = subprocess.Popen(
            command, cwd=ROOT, stdout=stream, stderr=subprocess.STDOUT, env={**os.environ, **(environment or {})}
        )
        try:
            # The system's own account: of the process and of those that it has waited for.
            _, status, usage = os.wait4(process.pid, 0)
        except BaseException:
            process.terminate()
            process.wait()
            raise
        wall_s = perf_counter() - began
    process.returncode = os.waitstatus_to_exitcode(status)
    output = log.read_text(errors="replace")
    if process.returncode:
        raise RunFailedError(f"{' '.join(command)}: exit status {process.returncode}: {output[-2000:]}")
    return Usage(wall_s, usage.ru_utime + usage.ru_stime, output)

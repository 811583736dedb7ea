"""Watches a command from outside: memory and open files of each of its processes, by what they do."""

import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic

import numpy as np
import psutil

from benchmarks.city import ROOT
from benchmarks.processes import RunFailedError

EVERY_S = 0.5
# Each process starts the next one: the command, the process of a scenario, the process of SUMO.
ROLES = ("command", "evaluator", "SUMO")
STARTED = "spawn_main"


@dataclass(frozen=True)
class Watched:
    """A process over its life.

    Attributes:
        time_s: (T,) seconds since the start of the command.
        memory_mb: (T,) resident memory of its own, without what it shares with others.
        handles: (T,) open files, pipes and sockets.
    """

    time_s: list[float] = field(default_factory=list)
    memory_mb: list[float] = field(default_factory=list)
    handles: list[int] = field(default_factory=list)

    def figures(self) -> dict[str, float]:
        """Return memory and handles on the way, and the growth of memory over the second half, without the end."""
        time_s, memory_mb, handles = np.array(self.time_s), np.array(self.memory_mb), np.array(self.handles)
        quarter, half, late = (int(share * (len(time_s) - 1)) for share in (0.25, 0.5, 0.9))
        seconds, course = time_s[half : late + 1], memory_mb[half : late + 1]
        slope = float(np.polyfit(seconds, course, 1)[0]) if np.ptp(seconds) > 0.0 else 0.0
        return {
            "quarter_mb": float(memory_mb[quarter]),
            "half_mb": float(memory_mb[half]),
            "late_mb": float(memory_mb[late]),
            "peak_mb": float(memory_mb.max()),
            "growth_mb": slope * float(np.ptp(seconds)),
            "handles_half": float(handles[half]),
            "handles_late": float(handles[late]),
        }


def watch(command: Sequence[str], log: Path) -> dict[str, Watched]:
    """Run `command` to its end; return its processes by their roles.

    Raises:
        RunFailedError: its exit status is not 0.
    """
    found: dict[str, Watched] = {}
    with log.open("w") as stream:
        began = monotonic()
        process = subprocess.Popen(command, cwd=ROOT, stdout=stream, stderr=subprocess.STDOUT)
        try:
            while process.poll() is None:
                _sample(process.pid, monotonic() - began, found)
                try:
                    process.wait(EVERY_S)
                except subprocess.TimeoutExpired:
                    continue
        finally:
            if process.poll() is None:
                process.terminate()
                process.wait()
    if process.returncode:
        words = log.read_text(errors="replace")[-2000:]
        raise RunFailedError(f"{' '.join(command)}: exit status {process.returncode}: {words}")
    return found


def _sample(pid: int, time_s: float, found: dict[str, Watched]) -> None:
    for role, process in _processes(pid).items():
        try:
            memory, handles = process.memory_info(), process.num_fds()
        except psutil.Error:  # it has just ended
            continue
        watched = found.setdefault(role, Watched())
        watched.time_s.append(time_s)
        watched.memory_mb.append((memory.rss - memory.shared) / 2**20)
        watched.handles.append(handles)


def _processes(pid: int) -> dict[str, psutil.Process]:
    result: dict[str, psutil.Process] = {}
    try:
        process = psutil.Process(pid)
        for role in ROLES:
            result[role] = process
            below = [child for child in process.children() if any(STARTED in word for word in child.cmdline())]
            if not below:
                break
            process = below[0]
    except psutil.Error:  # one has just ended
        pass
    return result

"""The programs and tools that come with SUMO, run as processes."""

import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from gpsec.core.errors import MachineError
from gpsec.sumo.home import environment, program, sumo_home

_NO_MEMORY = ("bad_alloc", "MemoryError", "annot allocate memory")


@dataclass(frozen=True)
class Limits:
    """What a program may use.

    Attributes:
        time_s: until it is ended.
        memory_bytes: of address space; only Linux holds it to that.
    """

    time_s: float = 600.0
    memory_bytes: int = 4 << 30


def run_program(
    name: str, arguments: Sequence[str], folder: Path, limits: Limits | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a program of SUMO, such as netconvert, inside `folder`; its exit status is the caller's to judge.

    Raises:
        MachineError: it cannot be started, was killed, ran out of memory, or took more than the limits allow.
    """
    return _run(name, [str(program(name)), *arguments], folder, limits)


def run_tool(name: str, arguments: Sequence[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a Python tool of SUMO, such as randomTrips.py, inside `folder`; its exit status is the caller's to judge.

    Raises:
        MachineError: it cannot be started, was killed, or ran out of memory.
    """
    return _run(name, [sys.executable, str(sumo_home() / "tools" / name), *arguments], folder, None)


def _run(name: str, command: list[str], folder: Path, limits: Limits | None) -> subprocess.CompletedProcess[str]:
    """Run a command; `name` is for what is said of it."""
    pipe = subprocess.PIPE
    try:
        started = subprocess.Popen(
            command,
            cwd=folder,
            env=environment(),
            stdin=subprocess.DEVNULL,
            stdout=pipe,
            stderr=pipe,
            text=True,
            errors="replace",
        )
    except OSError as error:
        raise MachineError(f"{name} cannot be started: {error.strerror or error}") from None
    with started as process:
        try:
            if limits is not None:
                _confine(process.pid, limits.memory_bytes)
            printed, complained = process.communicate(timeout=None if limits is None else limits.time_s)
        except subprocess.TimeoutExpired as expired:
            raise MachineError(f"{name} was ended, for it had no result after {expired.timeout:.0f} s") from None
        finally:
            process.kill()  # no harm to one that has ended
    if process.returncode == -signal.SIGKILL:
        raise MachineError(f"{name} was killed, most likely since the system ran out of memory")
    if process.returncode != 0 and any(words in complained for words in _NO_MEMORY):
        allowed = "there is" if limits is None else f"the {limits.memory_bytes / 2**30:.3g} GiB that it may have"
        raise MachineError(f"{name} needs more memory than {allowed}")
    return subprocess.CompletedProcess(command, process.returncode, printed, complained)


def _confine(process: int, memory_bytes: int) -> None:
    """Bound the address space of a process that has been started; where the system cannot, leave it as it is."""
    if sys.platform != "linux":
        return
    import resource

    with suppress(ProcessLookupError):  # it has ended
        _, hard = resource.prlimit(process, resource.RLIMIT_AS)
        allowed = memory_bytes if hard == resource.RLIM_INFINITY else min(memory_bytes, hard)
        resource.prlimit(process, resource.RLIMIT_AS, (allowed, hard))

"""How processes are started and left in peace: interrupts, threads of libraries, output."""

import gc
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import current_process, parent_process, resource_tracker
from multiprocessing.connection import wait
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from gpsec.core.errors import GpsecError

# There is a process for every core; more threads in libraries would only fight over them.
_ONE_THREAD = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMEXPR_NUM_THREADS")
_INTERRUPTS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_CAUSES = {
    signal.SIGKILL: "most likely the system ran out of memory",
    signal.SIGBUS: "most likely a disk or shared memory is full",
    signal.SIGXCPU: "it reached the limit of processor time",
    signal.SIGXFSZ: "it reached the limit of the size of a file",
    signal.SIGABRT: "it gave up, for want of memory or by a fault of its own",
    signal.SIGTERM: "it was told to end",
    signal.SIGINT: "it was told to end",
    signal.SIGHUP: "it was told to end",
}

_HIDING = threading.Lock()


class _Process(SpawnProcess):
    """A process that does not import the program's main module.

    A script that calls gpsec would begin anew in it, unless it minds ``if __name__ == "__main__"``.
    """

    def start(self) -> None:
        with _main_module_hidden():
            super().start()


class _Spawn(SpawnContext):
    Process = _Process


SPAWN = _Spawn()
"""Context of all processes whose work is gpsec's own: no function of the program's main module can be sent there."""


def check_may_start() -> None:
    """Check that this process may start others.

    Raises:
        GpsecError: it is one that may not, such as those of `multiprocessing.Pool`.
    """
    if current_process().daemon:
        raise GpsecError(
            "gpsec starts processes, which one of multiprocessing.Pool may not: expected a thread, or a process of "
            "concurrent.futures.ProcessPoolExecutor"
        )


def start(process: BaseProcess) -> None:
    """Start a process whose libraries have one thread, and which leaves interrupts to its parent."""
    with _deaf_to_interrupts(), _one_thread():
        process.start()


def end_with_parent() -> None:
    """Let this process end as soon as the one that started it is gone, however that ended."""
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent.sentinel,), daemon=True).start()


def collect_garbage_rarely() -> None:
    """Let Python look for cycles of objects less often: the many objects of modules and tables hardly make any."""
    gc.set_threshold(50_000, 20, 100)


def _end_after(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)


def ended_early(process: str, exit_code: int | None, crash: str) -> str:
    """Say how a `process` ended that had more to do, and the likely cause.

    `exit_code` is negative for a signal, as `BaseProcess` has it; `crash` is what a fault of the program is called.
    """
    if exit_code is None or exit_code >= 0:
        return f"{process} ended early (exit status {exit_code})"
    try:
        number = signal.Signals(-exit_code)
    except ValueError:  # one of the real-time signals, which have no names
        return f"{process} ended early (signal {-exit_code})"
    return f"{process} ended early ({number.name}: {_CAUSES.get(number, crash)})"


def redirect_output(log: Path) -> None:
    """Send what SUMO prints to a file: on the terminal it would tear the progress bars."""
    sys.stdout.flush()
    sys.stderr.flush()
    target = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    for descriptor in (1, 2):
        os.dup2(target, descriptor)
    os.close(target)


@contextmanager
def ignore_interrupts() -> Iterator[None]:
    """Ignore Ctrl-C and its like for the moment that it takes to finish what is begun."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, signal.SIG_IGN) for number in _INTERRUPTS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Let a process that is started inherit blocked signals, which are for the parent; ours come when it is over."""
    resource_tracker.ensure_running()  # it would unblock them if it had to be started later
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _INTERRUPTS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _main_module_hidden() -> Iterator[None]:
    """Keep from a process that is started where the main module is."""
    main = vars(sys.modules["__main__"])
    with _HIDING:
        before: dict[str, Any] = {name: main[name] for name in ("__spec__", "__file__") if name in main}
        main.update(dict.fromkeys(before))
        try:
            yield
        finally:
            main.update(before)


@contextmanager
def _one_thread() -> Iterator[None]:
    before = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value

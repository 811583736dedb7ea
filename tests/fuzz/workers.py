"""Processes that try damaged inputs: one that crashes is seen, and another takes its place."""

import os
import signal
import time
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path

from .attempt import attempt
from .material import Material
from .readers import readers

# SUMO, netconvert and the compiler of kernels are given their time.
PATIENCE_S = 300.0


@dataclass(frozen=True)
class Case:
    """A damaged input: which reader, and the number that it is made from."""

    reader: str
    number: int


class Worker:
    """A process that tries one case at a time."""

    def __init__(self, material: Material, folder: Path) -> None:
        """Start it; it works in `folder`."""
        self._material, self._folder = material, folder
        self._start()

    def _start(self) -> None:
        context = get_context("spawn")
        self.connection, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs, self._material, self._folder), daemon=False)
        self._process.start()
        theirs.close()

    def send(self, case: Case) -> None:
        """Let it begin with a case."""
        self.connection.send(case)
        self._since_s = time.monotonic()

    @property
    def ready(self) -> bool:
        """Whether there is an answer, also that it has crashed, or has had its time."""
        return self.connection.poll() or time.monotonic() > self._since_s + PATIENCE_S

    def answer(self) -> str:
        """Return what was wrong with the last case, empty where nothing was; wait for it."""
        try:
            if self.connection.poll(max(0.0, self._since_s + PATIENCE_S - time.monotonic())):
                found: str = self.connection.recv()
                return found
            sentence = f"took longer than {PATIENCE_S:g} s"
        except (EOFError, OSError):
            self._process.join()
            code = self._process.exitcode or 0
            sentence = f"crashed ({signal.Signals(-code).name if code < 0 else f'exit status {code}'})"
        self.close()
        self._start()
        return sentence

    def close(self) -> None:
        """End the process."""
        self.connection.close()
        self._process.kill()
        self._process.join()


def _work(connection: Connection, material: Material, folder: Path) -> None:
    known = readers(material)
    # What C code prints goes nowhere; a traceback of a process below would be among it, but so would SUMO's words.
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)
    try:
        while True:
            case = connection.recv()
            connection.send(attempt(case.reader, known[case.reader], case.number, folder))
    except (EOFError, OSError):
        return

"""Results by content: ``store/<fingerprint>`` is a whole run that would come out the same again.

Any number of processes, on one machine or on several with a disk in common, work on one store. Who begins a run claims
it, so that nobody else does; a claim whose owner is gone falls. A run that was made twice all the same is harmless:
the bytes are the same, and a folder takes its place in one step.
"""

import fcntl
import json
import os
import shutil
import socket
import time
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from secrets import token_hex
from typing import BinaryIO

from gpsec.core.errors import GpsecError
from gpsec.core.system import in_a_sentence
from gpsec.outcomes.tables import whole
from gpsec.types.constants import MANIFEST

# The owner of a claim on another machine shows that it is there by touching it; clocks may differ by a part of this.
BEAT_S, DEAD_AFTER_S = 10.0, 120.0
_FORM = "store.json"
_VERSION = 1


@dataclass
class Claim:
    """The right to make a run.

    Attributes:
        fingerprint: of the run.
        work: an empty folder for it, in which its own is called by the fingerprint.
    """

    fingerprint: str
    work: Path
    _path: Path
    _lock: BinaryIO
    _beat_s: float

    @property
    def made(self) -> Path:
        """The folder of the run while it is made."""
        return self.work / self.fingerprint

    def beat(self) -> None:
        """Show to other machines that somebody is at work."""
        if time.monotonic() - self._beat_s > BEAT_S:
            self._beat_s = time.monotonic()
            with suppress(OSError):
                os.utime(self._path)

    def release(self) -> None:
        """Give it back, and remove what was made."""
        shutil.rmtree(self.work, ignore_errors=True)
        with suppress(OSError):
            self._path.unlink()
        self._lock.close()


@dataclass(frozen=True)
class Store:
    """A folder of runs.

    Attributes:
        path: of it.
    """

    path: Path

    def make(self) -> None:
        """Make it, where it is not there.

        Raises:
            GpsecError: it is of another version, or cannot be written.
        """
        self.check()
        with in_a_sentence(f"{self.path}: cannot be written"):
            self._claims.mkdir(parents=True, exist_ok=True)
            self._work.mkdir(exist_ok=True)
            if not (self.path / _FORM).exists():
                with whole(self.path / _FORM) as partial:
                    partial.write_text(json.dumps({"gpsec_store": _VERSION}) + "\n", "utf-8")

    def check(self) -> None:
        """Check that it is a store, if it is there.

        Raises:
            GpsecError: it is something else, or of another version.
        """
        file = self.path / _FORM
        if not self.path.exists() or (not file.exists() and not any(self.path.iterdir())):
            return
        try:
            found = json.loads(file.read_text("utf-8")).get("gpsec_store")
        except (OSError, ValueError, AttributeError):
            raise GpsecError(f"{self.path}: expected a store of gpsec, found other files") from None
        if found != _VERSION:
            raise GpsecError(
                f"{self.path}: expected a store of form {_VERSION}, found one of form {found}: it is of another version"
                " of gpsec; choose another --store"
            )

    def result(self, fingerprint: str) -> Path:
        """Return where a run is, or will be."""
        return self.path / fingerprint

    def has(self, fingerprint: str) -> bool:
        """Return whether a run is there; folders take their place when they are whole."""
        return (self.path / fingerprint / MANIFEST).is_file()

    def claim(self, fingerprint: str) -> Claim | None:
        """Return the right to make a run, None where somebody else has it.

        Raises:
            GpsecError: the disk refuses.
        """
        nonce = token_hex(4)
        work, place = self._work / f"{fingerprint[:16]}-{nonce}", self._claims / fingerprint
        with in_a_sentence(f"{self.path}: cannot be written"):
            self._bury(place)
            mine = self._claims / f".{fingerprint}-{nonce}"
            lock = mine.open("wb")
            try:
                with suppress(OSError):  # a disk without locks: then the beat alone tells
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                stated = {"machine": _machine(), "host": socket.gethostname(), "pid": os.getpid(), "work": work.name}
                lock.write(json.dumps(stated).encode())
                lock.flush()
                os.link(mine, place)  # in one step, and locked already
            except FileExistsError:
                lock.close()
                return None
            finally:
                mine.unlink(missing_ok=True)
            work.mkdir()
        return Claim(fingerprint, work, place, lock, time.monotonic())

    def claimed(self, fingerprint: str) -> bool:
        """Return whether somebody is making a run."""
        place = self._claims / fingerprint
        return place.exists() and not _is_dead(place)

    def publish(self, claim: Claim) -> None:
        """Let a run take its place, and give the claim back.

        It is not written through to the disk: what a power cut spoils is found by its digests, and made again.

        Raises:
            GpsecError: the disk refuses.
        """
        try:
            with in_a_sentence(f"{self.path}: cannot be written"):
                target = self.result(claim.fingerprint)
                if target.exists() and not self.has(claim.fingerprint):  # somebody has spoilt it by hand
                    shutil.rmtree(target)
                try:
                    claim.made.rename(target)
                except OSError:
                    if not self.has(claim.fingerprint):  # else somebody has made the same
                        raise
        finally:
            claim.release()

    def discard(self, fingerprint: str) -> None:
        """Remove a run, which is to be made again.

        Raises:
            GpsecError: the disk refuses.
        """
        with in_a_sentence(f"{self.result(fingerprint)}: cannot be removed"):
            shutil.rmtree(self.result(fingerprint))

    def sweep_up(self) -> None:
        """Remove what workers that are gone have left."""
        for place in self._claims.iterdir():  # also those that were killed while they buried another one
            self._bury(place)

    @property
    def _claims(self) -> Path:
        return self.path / ".claims"

    @property
    def _work(self) -> Path:
        return self.path / ".work"

    def _bury(self, place: Path) -> None:
        """Remove a claim whose owner is gone, and what that has left."""
        if not _is_dead(place):
            return
        aside = place.with_name(f".{place.name}-{token_hex(4)}")
        with suppress(OSError, ValueError, LookupError, TypeError):
            place.rename(aside)  # one of those who try it succeeds
            if not _is_dead(aside):  # somebody has buried it before us, and this one is new
                os.link(aside, place)
                aside.unlink()
                return
            left = str(json.loads(aside.read_text("utf-8"))["work"])
            if left == Path(left).name:
                shutil.rmtree(self._work / left, ignore_errors=True)
        aside.unlink(missing_ok=True)


def _is_dead(place: Path) -> bool:
    """Return whether there is a claim whose owner is gone."""
    try:
        with place.open("rb") as file:
            age_s = time.time() - os.fstat(file.fileno()).st_mtime
            stated = json.loads(file.read() or b"{}")
            if stated.get("machine") == _machine():
                try:
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    return False
                return True
    except FileNotFoundError:
        return False
    except (OSError, ValueError, AttributeError):
        return True
    return age_s > DEAD_AFTER_S


@cache
def _machine() -> str:
    """Return what tells a running system from all others: locks of files are seen by all that runs on it."""
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip()
    except OSError:
        return socket.gethostname()

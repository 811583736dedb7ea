"""How far many tasks are: done, running, failed, and the time left."""

import time
from dataclasses import dataclass, field

from gpsec.core.progress import DONE, FAILED, Progress

# Before a quarter of a task is done, nobody knows how long one takes.
_ENOUGH = 0.25


@dataclass
class Tally:
    """What tasks have told.

    Attributes:
        count: of all tasks.
        done, failed: of those that have ended.
    """

    count: int
    done: int = 0
    failed: int = 0
    _found: int = 0
    _running: dict[str, float] = field(default_factory=dict)
    _began_s: float = field(default_factory=lambda: time.monotonic())

    def add(self, progress: Progress) -> None:
        """Count a report."""
        if progress.stage not in (DONE, FAILED):
            share = min(progress.time_s / progress.duration_s, 1.0) if progress.duration_s else 0.0
            self._running[progress.scenario] = share
            return
        ran = self._running.pop(progress.scenario, None) is not None
        if progress.stage == FAILED:
            self.failed += 1
            return
        self.done += 1
        self._found += not ran

    @property
    def ended(self) -> int:
        """Tasks that are over."""
        return self.done + self.failed

    @property
    def left_s(self) -> float | None:
        """Seconds that the rest will take if it goes on as so far; None where nothing has been done yet."""
        share = sum(self._running.values())
        worked = self.ended - self._found + share
        if worked < _ENOUGH:
            return None
        return (time.monotonic() - self._began_s) / worked * max(self.count - self.ended - share, 0.0)

    def text(self) -> str:
        """Say it in a line."""
        parts = [f"{self.done} of {self.count} done"]
        if self._running:
            parts.append(f"{len(self._running)} running")
        if self.failed:
            parts.append(f"{self.failed} failed")
        left_s = self.left_s
        if left_s is not None and self.ended < self.count:
            parts.append(f"about {span(left_s)} left")
        return ", ".join(parts)


def span(seconds: float) -> str:
    """Return a time as people say it: ``40 s``, ``12 min``, ``3 h 20 min``, ``2 d 4 h``."""
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    if minutes < 120:
        return f"{minutes} min"
    hours, rest = divmod(minutes, 60)
    if hours < 48:
        return f"{hours} h {rest} min"
    return f"{hours // 24} d {hours % 24} h"

"""Progress where there is no terminal: a short run is seen to run, a long one does not fill the log."""

import io

import pytest
from rich.console import Console

from gpsec.console import bars
from gpsec.console.bars import Lines
from gpsec.core.progress import DONE, Progress


def said(monkeypatch: pytest.MonkeyPatch, told: list[tuple[float, Progress]]) -> list[str]:
    """Return the lines on progress that is told at these times, in seconds."""
    out, now_s = io.StringIO(), 0.0
    monkeypatch.setattr(bars.time, "monotonic", lambda: now_s)
    with Lines(Console(file=out)) as lines:
        for now_s, progress in told:  # noqa: B007
            lines(progress)
    return out.getvalue().splitlines()


def running(time_s: float) -> Progress:
    return Progress("town", time_s, 60.0, vehicles=3, tracks=5, real_time_factor=20.0)


def test_a_short_run_says_where_it_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    told = [(0.0, running(0.1)), (0.5, running(20.0)), (0.9, running(59.0)), (1.0, Progress("town", stage=DONE))]
    numbers = "3 vehicles, 5 tracks, 20.0x real time"
    assert said(monkeypatch, told) == [
        f"town: running: 0/60 s, {numbers}",
        f"town: running: 59/60 s, {numbers}",
        "town: done",
    ]


def test_lines_become_fewer(monkeypatch: pytest.MonkeyPatch) -> None:
    told = [(float(second), running(float(second) + 0.1)) for second in range(61)]
    seconds = [int(line.split("/")[0].rpartition(" ")[2]) for line in said(monkeypatch, told)]
    assert seconds == [0, 1, 3, 7, 15, 30, 45, 60]


def test_nothing_is_said_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    told = [(0.0, Progress("town", stage="loading the net")), (0.1, running(0.1)), (0.2, Progress("town", stage=DONE))]
    assert [line.partition(",")[0] for line in said(monkeypatch, told)] == [
        "town: loading the net",
        "town: running: 0/60 s",
        "town: done",
    ]

"""What is said of many tasks: done, running, failed, and the time left."""

import io

import pytest
from rich.console import Console

from gpsec.console import bars, tally
from gpsec.console.bars import TallyLines, display
from gpsec.console.tally import Tally, span
from gpsec.core.progress import DONE, FAILED, Progress


def test_what_is_there_already_says_nothing_of_the_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = 100.0
    monkeypatch.setattr(tally.time, "monotonic", lambda: now_s)
    of_ten = Tally(10)
    for number in range(4):
        of_ten.add(Progress(f"old {number}", stage=DONE))
    assert of_ten.text() == "4 of 10 done"
    of_ten.add(Progress("new", time_s=0.0, duration_s=60.0))
    now_s = 130.0
    of_ten.add(Progress("new", stage=DONE))
    of_ten.add(Progress("half", time_s=30.0, duration_s=60.0))
    # One and a half of six took 30 s.
    assert of_ten.left_s == pytest.approx(30.0 / 1.5 * 4.5)
    of_ten.add(Progress("bad", stage="running"))
    of_ten.add(Progress("bad", stage=FAILED))
    assert of_ten.text() == "5 of 10 done, 1 running, 1 failed, about 42 s left"


@pytest.mark.parametrize(
    ("seconds", "said"), [(9.6, "10 s"), (720.0, "12 min"), (12_000.0, "3 h 20 min"), (187_200.0, "2 d 4 h")]
)
def test_spans(seconds: float, said: str) -> None:
    assert span(seconds) == said


def test_many_tasks_have_a_line_together_and_each_note_once(monkeypatch: pytest.MonkeyPatch) -> None:
    out, now_s = io.StringIO(), 0.0
    monkeypatch.setattr(bars.time, "monotonic", lambda: now_s)
    with display(Console(file=out, width=200), 40) as show:
        assert isinstance(show, TallyLines)
        for number in range(40):
            now_s += 1.0
            show(Progress(str(number), note="no sublanes"))
            show(Progress(str(number), stage=FAILED if number == 7 else DONE))
    lines = out.getvalue().splitlines()
    assert lines.count("0: no sublanes") == 1
    assert "7: failed" in lines
    assert lines[-1] == "39 of 40 done, 1 failed"
    assert len(lines) < 12

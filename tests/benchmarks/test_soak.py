"""The soak sees what it is there to see; the long run itself is for `make soak`."""

import json
import sys

import pytest

from benchmarks import city, soak
from benchmarks.processes import RunFailedError
from benchmarks.soak import main, not_finite
from benchmarks.watch import Watched, watch
from tests.benchmarks.test_bench import HAMLET


def test_growth_is_that_of_the_second_half_without_the_end():
    times = [float(at) for at in range(101)]
    memory = [2.0 * min(at, 50) + 0.5 * max(0, min(at, 90) - 50) + 70.0 * (at > 90) for at in range(101)]
    figures = Watched(times, memory, [9] * 101).figures()
    assert figures["growth_mb"] == pytest.approx(0.5 * 40)
    assert figures["half_mb"] == 100.0
    assert figures["peak_mb"] == memory[-1]


def test_a_command_is_watched_while_it_holds_memory_and_files(tmp_path):
    code = "import time; held = [open('/dev/null') for _ in range(40)]; more = bytearray(200 << 20); time.sleep(1.5)"
    found = watch((sys.executable, "-c", code), tmp_path / "log")
    assert list(found) == ["command"]
    assert max(found["command"].memory_mb) > 200.0
    assert max(found["command"].handles) >= 43


def test_a_command_that_fails_is_told_with_its_last_words(tmp_path):
    with pytest.raises(RunFailedError, match="exit status 3: alas"):
        watch((sys.executable, "-c", "print('alas'); raise SystemExit(3)"), tmp_path / "log")


@pytest.mark.parametrize(
    ("cell", "bad"), [("nan", True), ("-inf", True), ("", False), ("nancy", False), ("1.5", False)]
)
def test_a_number_that_is_none_is_found(tmp_path, cell, bad):
    table = tmp_path / "t.csv"
    table.write_text(f"id,error_m\na,0.5\nb,{cell}\n")
    assert not_finite(table) == (["t.csv: column error_m, line 3"] if bad else [])


def test_the_command_tells_of_each_process(monkeypatch, tmp_path, tmp_path_factory):
    monkeypatch.setattr(city, "BUILT", tmp_path_factory.mktemp("built"))
    monkeypatch.setattr(soak, "SMALL_CITY", HAMLET)
    monkeypatch.setitem(soak.AT_ONCE, HAMLET.name, 60)
    monkeypatch.setattr(soak, "QUICK_VEHICLE_STEPS", 6_000)
    assert main(["--quick", "--out", str(tmp_path / "soak.json")]) == 0
    told = json.loads((tmp_path / "soak.json").read_text())
    assert set(told["processes"]) == {"command", "evaluator", "SUMO", "plain SUMO"}
    assert told["vehicle_steps"] > 3_000
    assert told["found"] == []

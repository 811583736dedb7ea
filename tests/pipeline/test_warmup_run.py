from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gpsec.core import kernels
from gpsec.core.errors import GpsecError
from gpsec.core.kernels import Compiled, kernel, only_compile
from gpsec.pipeline.warmup_run import warm_up
from gpsec.running import warmup
from gpsec.running import workers as runs
from gpsec.scenario import Scenario

Called = set[tuple[str, str]]


@pytest.fixture
def claims(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where kernels that are only compiled are noted; they are run again after the test."""
    folder = tmp_path / "claims"
    folder.mkdir()
    monkeypatch.setattr(kernels, "_claims", None)
    return folder


@pytest.fixture
def noted(monkeypatch: pytest.MonkeyPatch) -> Called:
    """The kernels that are called, with the types that they are called with."""
    called: Called = set()
    call = Compiled.__call__

    def note(self: Compiled, *args: object) -> object:
        if self._keep:
            types = [self.dispatcher.typeof_pyval(argument) for argument in args]
            called.add((f"{self.__module__}.{self.__qualname__}", str(types)))
        return call(self, *args)

    monkeypatch.setattr(Compiled, "__call__", note)
    return called


def test_a_run_calls_no_kernel_that_was_not_warmed_up(town, traffic, replay, go, claims, noted, tmp_path, monkeypatch):
    monkeypatch.setattr(Compiled, "_compile_for", lambda self, args, claims: flag(args))
    only_compile(claims)
    (tmp_path / "tables").mkdir()
    warm_up(town, tmp_path / "tables")
    warmed = set(noted)
    noted.clear()
    kernels._claims = None
    replay(traffic)
    go(town)
    assert noted <= warmed
    assert len(noted) > 15


def flag(args: tuple) -> None:
    for flags in kernels._flags(args):
        flags[...] = True


@kernel
def count_up(numbers: np.ndarray, flags: np.ndarray) -> None:
    for i in range(len(numbers)):
        numbers[i] += 1.0
        flags[i] = False


def test_a_kernel_is_compiled_by_one_process_and_not_run(claims):
    first, second = Compiled(count_up.__wrapped__, keep=True), Compiled(count_up.__wrapped__, keep=True)
    numbers, flags = np.zeros(3), np.zeros(3, np.bool_)
    only_compile(claims)
    first(numbers, flags)
    second(numbers, flags)
    assert len(list(claims.iterdir())) == 1
    assert [len(one.dispatcher.signatures) for one in (first, second)] == [1, 0]
    assert numbers.tolist() == [0.0, 0.0, 0.0]
    assert flags.all()
    first(numbers.astype(np.float32), flags)
    assert len(first.dispatcher.signatures) == 2


def test_kernels_of_one_maker_are_each_compiled(claims):
    first, second = adding(1.0), adding(2.0)
    only_compile(claims)
    for one in (first, second):
        one(np.zeros(3))
    assert [len(one.dispatcher.signatures) for one in (first, second)] == [1, 1]


def adding(amount: float) -> Compiled:
    @kernel
    def add(numbers: np.ndarray) -> None:
        for i in range(len(numbers)):
            numbers[i] += amount

    return add


def test_what_goes_wrong_is_left_to_the_run(town, tmp_path, monkeypatch):
    seen: list = []
    monkeypatch.setattr(warmup, "are_compiled", lambda: False)
    monkeypatch.setattr(warmup, "_warm_up", give_up)
    warmup.compile_kernels([town], tmp_path, seen.append)
    assert [progress.stage for progress in seen] == ["compiling kernels"]
    assert "once" in seen[0].note


def test_what_a_killed_warm_up_has_left_is_in_nobody_s_way(town, tmp_path, monkeypatch):
    for name in (".claims", ".warmup-0", ".warmup-1"):
        (tmp_path / name).mkdir()
    left = sorted(tmp_path.iterdir())
    monkeypatch.setattr(warmup, "are_compiled", lambda: False)
    monkeypatch.setattr(warmup, "_warm_up", give_up)
    warmup.compile_kernels([town], tmp_path, lambda progress: None)
    assert sorted(tmp_path.iterdir()) == left


def give_up(scenarios: list[Scenario], folder: Path, claims: Path) -> None:
    raise GpsecError("no such net")


def test_compiled_kernels_are_not_warmed_up(town, tmp_path, monkeypatch):
    report: Callable = pytest.fail
    monkeypatch.setattr(warmup, "are_compiled", lambda: True)
    warmup.compile_kernels([town], tmp_path, report)
    monkeypatch.setattr(warmup, "are_compiled", lambda: False)
    warmup.compile_kernels([town.model_copy(update={"engine": "reference"})], tmp_path, report)
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_warmed_up_for_a_cache_that_cannot_be_written(town, tmp_path, monkeypatch):
    seen: list = []
    monkeypatch.setattr(warmup, "are_compiled", lambda: False)
    monkeypatch.setattr(warmup, "can_keep", lambda folder: False)
    warmup.compile_kernels([town], tmp_path, seen.append)
    assert ["cannot be written" in progress.note for progress in seen] == [True]
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_while_kernels_are_compiled_is_one_of_the_run(town, tmp_path, monkeypatch):
    def interrupted(*arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(runs, "compile_kernels", interrupted)
    outcome = runs.run_scenarios([town], tmp_path, 1, lambda progress: None)
    assert outcome.interrupted
    assert outcome.finished == []

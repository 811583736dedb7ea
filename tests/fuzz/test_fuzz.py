"""A sample of what `make fuzz` does for hours."""

import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gpsec.core.errors import GpsecError
from gpsec.scenario import load_scenario
from gpsec.scenario.overrides import parse_set

from . import mutators
from .attempt import attempt
from .material import Material, make
from .readers import Reader, readers
from .workers import Case, Worker

NAMES = (
    *("toml", "set", "sumocfg", "net", "routes", "additional", "opendrive", "openstreetmap", "demand"),
    *("recording", "log", "fcd", "lines", "log page", "tape", "calibration", "models", "report", "comparison", "trace"),
)
FEW = range(1, 7)


@pytest.fixture(scope="module")
def material(tmp_path_factory: pytest.TempPathFactory) -> Material:
    return make(tmp_path_factory.mktemp("material"))


@pytest.fixture(scope="module")
def worker(material, tmp_path_factory):
    started = Worker(material, tmp_path_factory.mktemp("cases") / "case")
    yield started
    started.close()


def test_every_reader_is_named(material):
    assert tuple(readers(material)) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_what_is_in_order_is_read_and_what_is_damaged_never_ends_in_a_traceback_or_a_crash(worker, name):
    for number in (0, *FEW):
        worker.send(Case(name, number))
        assert worker.answer() == "", f"python -m tests.fuzz --only {name!r} --first {number} --inputs 1"


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_many_damaged_inputs_of_a_reader(worker, name):
    for number in range(FEW.stop, 200):
        worker.send(Case(name, number))
        assert worker.answer() == "", f"python -m tests.fuzz --only {name!r} --first {number} --inputs 1"


@pytest.mark.parametrize(
    ("mutate", "data"),
    [
        (mutators.anything, b"some bytes"),
        (mutators.words, b'a = 1\nb = "x"\n'),
        (mutators.xml, b'<a><b c="1"/><d e="2">x</d></a>'),
        (mutators.json_, b'{"a": [1, {"b": 2}]}'),
        (mutators.table, b"a,b\n1,2\n3,4\n"),
    ],
)
def test_a_mutator_changes_what_it_is_given_and_the_same_number_gives_the_same(mutate, data):
    made = [mutators.several(mutate, data, Random(number)) for number in range(60)]
    assert made == [mutators.several(mutate, data, Random(number)) for number in range(60)]
    assert len(set(made)) > 20
    assert sum(one != data for one in made) > 50


def test_a_traceback_a_crash_and_an_escape_sequence_are_noticed(material, tmp_path, monkeypatch):
    def crash() -> int:
        raise ZeroDivisionError

    def shout() -> int:
        print("\x1b[31mred")
        return 2

    def refuse() -> int:
        raise GpsecError("no")

    def silent() -> int:
        return 1

    for read, number, words in (
        (crash, 1, "ZeroDivisionError"),
        (shout, 1, "prints '\\x1b'"),
        (refuse, 0, "refuses what is in order"),
        (silent, 1, "without a word"),
        (refuse, 1, ""),
    ):
        reader = Reader(read, {"file": b"1"}, {"file": mutators.anything})
        found = attempt("probe", reader, number, tmp_path / "case")
        assert (words in found) if words else found == ""


KEYS = st.sampled_from(
    ["fleet", "plans", "defences", "detection", "seed", "traffic", "fleet.profile", "plans.0.share", ""]
)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda below: st.lists(below, max_size=3) | st.dictionaries(st.text(max_size=5), below, max_size=3),
    max_leaves=6,
)


@pytest.fixture(scope="module")
def scenario(material, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("scenario")
    for name, content in readers(material)["toml"].files.items():
        (folder / Path(name).name).write_bytes(content)
    return folder


@settings(max_examples=150)
@given(st.tuples(KEYS, VALUES | st.text(max_size=40)))
def test_any_change_of_a_key_is_taken_or_refused(scenario, pair):
    key, value = pair
    with suppress(GpsecError):
        load_scenario(scenario, [parse_set(f"{key}={value}")])


def test_the_command_line_tries_as_many_as_asked_and_keeps_what_fails(tmp_path):
    command = [
        sys.executable,
        "-m",
        "tests.fuzz",
        "--only",
        "set",
        "--inputs",
        "3",
        "--jobs",
        "1",
        "--out",
        str(tmp_path),
    ]
    ran = subprocess.run(command, cwd=Path(__file__).parents[2], capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stdout.splitlines()[-1].strip()) == (0, "3 inputs, 0 failed")
    assert not list(tmp_path.iterdir())

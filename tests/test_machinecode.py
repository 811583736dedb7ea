"""Machine code is loaded where its sources are the same, wherever they lie, and only where it is whole."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import gpsec
from gpsec.core import caches, kernels

# Prints what the kernel gives, and how often it was found in the cache and not found.
CALL = """
import json, sys
import numpy as np
from plug.loops import fill
out = np.zeros(1)
fill(out)
stats = fill.dispatcher.stats
print(json.dumps([out[0], sum(stats.cache_hits.values()), sum(stats.cache_misses.values())]))
"""
LOOPS = """
from gpsec.core.kernels import kernel
from plug.helper import step

@kernel
def fill(out):
    for i in range(len(out)):
        out[i] = step(2.0)
"""
PICK = """
from gpsec.core.kernels import kernel

@kernel
def pick(pair, out):
    out[0] = pair.a
"""
CALL_PICK = CALL.replace("import fill", "import pick as fill\nfrom shapes import Pair").replace(
    "fill(out)", "fill(Pair(a=1.0, b=2.0), out)"
)
# A loop that is made for one function or another, which are of another package.
MAKER = """
from functools import cache
from gpsec.core.kernels import kernel

@cache
def filling(step, start):
    @kernel
    def fill(out):
        for i in range(len(out)):
            out[i] = step(start)

    return fill
"""
CALL_MADE = """
import json, sys
import numpy as np
from {maker} import filling
from plug.helper import step
from other import step as other
values, stats = [], [0, 0]
for fill in (filling(step, 2.0), filling(other, 2.0), filling(step, 3.0)):
    out = np.zeros(1)
    fill(out)
    values.append(out[0])
    stats[0] += sum(fill.dispatcher.stats.cache_hits.values())
    stats[1] += sum(fill.dispatcher.stats.cache_misses.values())
print(json.dumps(values + stats))
"""
HELPER = """
from gpsec.core.kernels import inline

@inline
def step(value):
    return {factor} * value
"""
# Two kernels of one name, each with a helper of one name that is too large to dissolve in it.
TWINS = """
from functools import cache
from gpsec.core.kernels import inline, kernel

@cache
def filling(factor):
    @inline
    def step(value):
LINES
        return factor * (1.0 + 0.0 * value)

    @kernel
    def fill(out):
        for i in range(len(out)):
            out[i] = step(out[i]) + step(2.0 * i)

    return fill
""".replace("LINES", "\n".join(f"        value = abs(value - {i}.5) / (1.0 + value * value)" for i in range(1, 60)))
CALL_TWINS = """
import json
import numpy as np
from plug.twins import filling
out = [np.zeros(1) for _ in FACTORS]
for factor, filled in zip(FACTORS, out):
    filling(factor)(filled)
print(json.dumps([filled[0] for filled in out]))
"""
GPSEC = """
import json
import numpy as np
from gpsec.core import noise
from gpsec.attacks.base import unit_vectors
noise.uniforms(np.ones(3, np.uint64), 1, 0)
unit_vectors(np.zeros(3))
print(json.dumps([sum(kernel.dispatcher.stats.cache_misses.values()) for kernel in (noise.uniforms, unit_vectors)]))
"""


class Place:
    """A package with a kernel and a helper, and the caches that it is run with."""

    def __init__(self, folder: Path, cache: Path) -> None:
        self.folder = folder
        self.environment = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA")}
        self.environment |= {"GPSEC_CACHE": str(cache)}

    def lay_out(self, factor: float = 2.0) -> None:
        plug = self.folder / "plug"
        plug.mkdir(parents=True, exist_ok=True)
        (plug / "__init__.py").touch()
        (plug / "loops.py").write_text(LOOPS)
        (plug / "helper.py").write_text(HELPER.format(factor=factor))

    def run(self, code: str = CALL, **environment: str) -> list[float]:
        path = os.pathsep.join([str(self.folder), *sys.path])
        done = subprocess.run(
            [sys.executable, "-B", "-c", code],
            cwd=self.folder,
            env={**self.environment, "PYTHONPATH": path, **environment},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)


@pytest.fixture
def place(tmp_path: Path) -> Place:
    made = Place(tmp_path / "here", tmp_path / "cache")
    made.lay_out()
    return made


@pytest.mark.parametrize("numba", [False, True])
def test_an_edited_helper_is_compiled_again(place: Place, tmp_path: Path, numba: bool) -> None:
    environment = {"NUMBA_CACHE_DIR": str(tmp_path / "numba")} if numba else {}
    assert place.run(**environment) == [4.0, 0, 1]
    place.lay_out(factor=200.0)
    assert place.run(**environment) == [400.0, 0, 1]
    kept = {path.relative_to(tmp_path).parts[0] for path in tmp_path.rglob("*.nbc")}
    assert kept == {"numba" if numba else "cache"}


def test_code_of_two_processes_does_not_mingle(place: Place) -> None:
    """The linker takes one of two symbols of a name, and numba numbers its symbols from one in each process."""
    (place.folder / "plug" / "twins.py").write_text(TWINS)
    for factor in (2.0, 3.0):
        assert place.run(CALL_TWINS.replace("FACTORS", f"[{factor}]")) == [2 * factor]
    assert place.run(CALL_TWINS.replace("FACTORS", "[2.0, 3.0]")) == [4.0, 6.0]
    assert place.run(CALL_TWINS.replace("FACTORS", "[3.0, 2.0]")) == [6.0, 4.0]


def test_an_edited_helper_of_a_third_package_is_compiled_again(place: Place) -> None:
    helper = place.folder / "plug" / "helper.py"
    helper.write_text("import third\n" + HELPER.replace("{factor} * value", "third.double(value)"))
    for factor in (2.0, 200.0):
        (place.folder / "third.py").write_text(HELPER.replace("step", "double").format(factor=factor))
        assert place.run() == [2.0 * factor, 0, 1]


def test_a_made_kernel_is_kept_for_its_functions_and_compiled_again_when_one_is_edited(place: Place) -> None:
    (place.folder / "plug" / "maker.py").write_text(MAKER)
    (place.folder / "other.py").write_text(HELPER.format(factor=10.0))
    code = CALL_MADE.format(maker="plug.maker")
    assert place.run(code) == [4.0, 20.0, 6.0, 0, 3]
    assert place.run(code) == [4.0, 20.0, 6.0, 3, 0]
    (place.folder / "other.py").write_text(HELPER.format(factor=11.0))
    assert place.run(code) == [4.0, 22.0, 6.0, 2, 1]


def test_a_kernel_that_gpsec_makes_of_a_function_of_others_heeds_their_sources(place: Place) -> None:
    ignored = shutil.ignore_patterns("models", "__pycache__")
    shutil.copytree(Path(gpsec.__file__).parent, place.folder / "gpsec", ignore=ignored)
    (place.folder / "gpsec" / "attacks" / "maker.py").write_text(MAKER)
    (place.folder / "other.py").write_text("import third\n" + HELPER.replace("{factor} * value", "third.double(value)"))
    helper = HELPER.replace("step", "double")
    code = CALL_MADE.format(maker="gpsec.attacks.maker")
    for factor, kept in ((10.0, 0), (10.0, 3), (11.0, 2)):
        (place.folder / "third.py").write_text(helper.format(factor=factor))
        assert place.run(code) == [4.0, 2.0 * factor, 6.0, kept, 3 - kept]


def test_another_install_of_the_same_sources_loads_what_is_there(place: Place, tmp_path: Path) -> None:
    assert place.run() == [4.0, 0, 1]
    other = Place(tmp_path / "other" / "place", tmp_path / "cache")
    other.lay_out()
    assert other.run() == [4.0, 1, 0]


def test_another_install_of_gpsec_compiles_only_the_layer_that_was_edited(tmp_path: Path) -> None:
    copies = [Place(tmp_path / name, tmp_path / "cache") for name in ("one", "two", "edited")]
    for copy in copies:
        ignored = shutil.ignore_patterns("models", "__pycache__")
        shutil.copytree(Path(gpsec.__file__).parent, copy.folder / "gpsec", ignore=ignored)
    with (tmp_path / "edited" / "gpsec" / "attacks" / "drift.py").open("a") as file:
        file.write("# edited\n")
    assert [copy.run(GPSEC) for copy in copies] == [[1, 1], [0, 0], [0, 1]]


def test_what_was_imported_before_an_edit_is_not_kept_as_what_is_there_after_it(place: Place, tmp_path: Path) -> None:
    edit = """
from pathlib import Path
import plug.loops
helper = Path(plug.loops.__file__).with_name("helper.py")
helper.write_text(helper.read_text().replace("2.0 *", "200.0 *"))
"""
    assert place.run(edit + CALL) == [4.0, 0, 1]
    assert not list(tmp_path.rglob("*.nbc"))
    assert place.run() == [400.0, 0, 1]


def test_a_damaged_entry_is_compiled_again(place: Place, tmp_path: Path) -> None:
    assert place.run() == [4.0, 0, 1]
    (entry,) = tmp_path.rglob("*.nbc")
    whole = entry.read_bytes()
    for damaged in (whole[:-1], whole[:-99] + bytes([whole[-99] ^ 8]) + whole[-98:]):
        entry.write_bytes(damaged)
        assert place.run() == [4.0, 0, 1]
    assert place.run() == [4.0, 1, 0]


def test_an_entry_that_somebody_else_could_write_is_not_even_unpickled(place: Place, tmp_path: Path) -> None:
    assert place.run() == [4.0, 0, 1]
    (entry,) = tmp_path.rglob("*.nbc")
    caches.write(entry, b"cbuiltins\nexit\n(I7\ntR.")  # a pickle that ends the process that reads it
    entry.chmod(0o666)
    assert place.run() == [4.0, 0, 1]


def test_structures_of_another_package_count_by_the_order_of_their_fields(place: Place) -> None:
    (place.folder / "plug" / "loops.py").write_text(PICK)
    for fields in (("a", "b"), ("b", "a")):
        lines = "".join(f"    {name}: float\n" for name in fields)
        (place.folder / "shapes.py").write_text(f"from typing import NamedTuple\nclass Pair(NamedTuple):\n{lines}")
        assert place.run(CALL_PICK) == [1.0, 0, 1]


def test_an_entry_is_for_one_set_of_processor_features(place: Place) -> None:
    assert place.run(NUMBA_CPU_NAME="generic") == [4.0, 0, 1]
    assert place.run() == [4.0, 0, 1]


def test_a_cache_that_cannot_be_written_costs_compiling_only(place: Place, tmp_path: Path) -> None:
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache" / "kernels").touch()
    assert place.run() == [4.0, 0, 1]


@pytest.fixture
def noted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An entry of a warm-up."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("GPSEC_CACHE", str(tmp_path))
    folder = caches.kernel_folder("gpsec.core.noise")
    assert folder is not None
    caches.write(folder / "entry.nbc", b"content")
    assert not kernels.are_compiled()
    kernels.note_warmup([f"{folder.name}/entry.nbc"])
    assert kernels.are_compiled()
    return folder / "entry.nbc"


def test_kernels_are_compiled_where_all_that_was_noted_will_be_loaded(noted: Path) -> None:
    whole = noted.read_bytes()
    noted.write_bytes(whole[:-1])
    assert not kernels.are_compiled()
    noted.write_bytes(whole)
    assert kernels.are_compiled()
    noted.unlink()
    assert not kernels.are_compiled()


def test_kernels_of_another_processor_are_not_compiled(noted: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kernels._machine.cache_clear()
    monkeypatch.setenv("NUMBA_CPU_NAME", "another")
    assert not kernels.are_compiled()
    monkeypatch.undo()
    kernels._machine.cache_clear()


def test_what_another_install_compiled_in_numba_s_way_does_not_count(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("GPSEC_CACHE", str(tmp_path))
    folder = caches.kernel_folder("gpsec.core.noise")
    assert folder is not None
    (folder / "gpsec_0123").mkdir(parents=True)
    (folder / "gpsec_0123" / "noise.uniforms-80.py311.nbi").touch()
    assert not kernels.are_compiled()

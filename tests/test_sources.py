"""What is kept depends on all that went into it: the layers of the digest are those of the import contracts."""

import ast
import shutil
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

import gpsec
from gpsec.core import sources

PACKAGE = Path(gpsec.__file__).parent
MAKERS = {f"gpsec.core.kernels.{name}" for name in ("kernel", "allocating_kernel", "inline")}


def imports(path: Path) -> set[str]:
    """Return what a module imports of gpsec, such as ``gpsec.core.kernels.kernel``."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return {name for name in found if name.startswith("gpsec.")}


def files(name: str) -> set[Path]:
    """Return the files that importing ``gpsec.a.b``, or `b` of ``gpsec.a``, runs."""
    found = set()
    for number in range(2, name.count(".") + 2):
        place = PACKAGE.joinpath(*name.split(".")[1:number])
        found |= {path for path in (place / "__init__.py", place.with_suffix(".py")) if path.is_file()}
    return found


def reached(path: Path) -> set[Path]:
    """Return the files of gpsec that a module imports, by others too."""
    found, waiting = {path}, [path]
    while waiting:
        for other in {file for name in imports(waiting.pop()) for file in files(name)} - found:
            found.add(other)
            waiting.append(other)
    return found


def layer(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


WITH_KERNELS = [path for path in sorted(PACKAGE.rglob("*.py")) if imports(path) & MAKERS]


def test_kernels_are_found() -> None:
    assert len(WITH_KERNELS) > 20


@pytest.mark.parametrize("path", WITH_KERNELS, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def test_the_digest_of_a_layer_covers_all_that_its_kernels_can_call(path: Path) -> None:
    assert {layer(other) for other in reached(path)} <= set(sources.covered(f"gpsec.{layer(path)}"))


def test_ranks_are_those_of_the_contracts(repository: Path) -> None:
    contracts = tomllib.loads((repository / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
    independent = next(set(contract["modules"]) for contract in contracts if contract["type"] == "independence")
    ranks = next(contract["layers"] for contract in contracts if contract["type"] == "layers")
    named = [{module.strip() for module in rank.split("|")} for rank in ranks]
    for number, rank in enumerate(named):
        for module in {one for one in rank if sources.owner(one).removeprefix("gpsec.") not in sources.ABOVE}:
            may = {module}.union(*named[number + 1 :]) - (independent - {module} if module in independent else set())
            assert {name.removeprefix("gpsec.") for name in may} <= set(sources.covered(module)), module
            others = {name.removeprefix("gpsec.") for rank in named[:number] for name in rank}
            ranked = {name for rank in sources.RANKS for name in rank}  # a basic may import another one
            assert not others & ranked & set(sources.covered(module)), module


@pytest.fixture
def copy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A copy of gpsec's sources, which digests are of."""
    shutil.copytree(PACKAGE, tmp_path / "gpsec", ignore=shutil.ignore_patterns("models", "__pycache__"))
    monkeypatch.setattr(sources, "_PACKAGE", tmp_path / "gpsec")
    forget()
    yield tmp_path / "gpsec"
    monkeypatch.undo()
    forget()


def forget() -> None:
    sources._noticed.clear()
    sources.notice.cache_clear()
    sources.digest.cache_clear()
    sources._digest_of.cache_clear()


def test_a_digest_goes_by_content_and_not_by_place(copy: Path) -> None:
    there = {name: sources.digest(f"gpsec.{name}") for name in sources.STAGES}
    forget()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sources, "_PACKAGE", PACKAGE)
        assert {name: sources.digest(f"gpsec.{name}") for name in sources.STAGES} == there
    assert len(set(there.values())) == len(there)


@pytest.mark.parametrize(
    ("edited", "changed"),
    [
        ("attacks/drift.py", {"attacks"}),
        ("pipeline/run.py", set()),
        ("hdmap/search.py", {"hdmap", *sources.STAGES}),
        ("filters/ekf.py", {"filters", "hdmap", *sources.STAGES}),
        ("types/tracks.py", {"types", "filters", "hdmap", *sources.STAGES}),
        ("core/kernels.py", {"core", "types", "filters", "hdmap", *sources.STAGES}),
    ],
)
def test_an_edit_changes_its_layer_and_those_above(copy: Path, edited: str, changed: set[str]) -> None:
    names = {"core", "types", "filters", "hdmap", *sources.STAGES}
    before = {name: sources.digest(f"gpsec.{name}") for name in names}
    with (copy / edited).open("a") as file:
        file.write("# edited\n")
    forget()
    assert {name for name in names if sources.digest(f"gpsec.{name}") != before[name]} == changed


def test_a_lock_of_an_editor_is_no_source(copy: Path) -> None:
    before = sources.digest("gpsec.attacks")
    (copy / "attacks" / ".#drift.py").symlink_to("user@host.1234")
    forget()
    assert sources.digest("gpsec.attacks") == before


def test_sources_that_change_after_they_were_imported_have_a_digest_of_their_own(copy: Path) -> None:
    before = sources.digest("gpsec.attacks")
    forget()
    sources.notice("gpsec.attacks")
    assert sources.are_unchanged("gpsec.attacks")
    with (copy / "core" / "geo.py").open("a") as file:
        file.write("# edited\n")
    assert not sources.are_unchanged("gpsec.attacks")
    mixed = sources.digest("gpsec.attacks")
    forget()
    assert sources.digest("gpsec.attacks") not in {before, mixed}  # what a process is given that imports it now


def test_a_script_has_no_digest() -> None:
    assert sources.digest("__main__") is None
    assert sources.digest("no_such_package") is None
    assert sources.owner("gpsec.detection.cusum") == "gpsec.detection"
    assert sources.owner("tests.test_sources") == "tests"

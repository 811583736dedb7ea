"""What the bytes of a run depend on, as one number: two runs of the same fingerprint have the same tables."""

import hashlib
import json
import platform
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from gpsec.attacks.registry import ATTACKS
from gpsec.core.errors import GpsecError
from gpsec.core.registry import Registry
from gpsec.core.sources import ABOVE
from gpsec.detection.registry import DETECTORS
from gpsec.localization.registry import RESPONSES
from gpsec.scenario import Scenario, parts
from gpsec.scenario.closed_loop import reactions_of
from gpsec.scenario.traffic import sumo_options
from gpsec.sensors.registry import PROFILES
from gpsec.sensors.shipped_tapes import load_tape
from gpsec.steering.registry import DYNAMICS, REACTIONS
from gpsec.traffic.input_files import input_files

# Settings that change what a run costs, and nothing in its tables.
_WITHOUT_EFFECT: dict[str, Any] = {
    "sumocfg": True,
    "threads": True,
    "parts": True,
    "detection": {"models"},
    "fleet": {"camera": {"tape"}, "gnss": {"tape"}},
}
# Layers that start runs or read their tables.
_BESIDE = ABOVE - {"engine", "imaging", "pipeline", "reference", "scenario"}
# Libraries that have a part in a table, with either engine; their versions are in the manifest too.
PACKAGES = (
    "eclipse-sumo",
    "libsumo",
    "sumolib",
    "traci",
    "numpy",
    "numba",
    "llvmlite",
    "scipy",
    "pandas",
    "pyarrow",
    "pyproj",
    "shapely",
    "torch",
    "scikit-learn",
    "filterpy",
    "pydantic",
)


def fingerprint(scenario: Scenario) -> str:
    """Return a digest of the configuration, the files that SUMO reads, the code, the models and the libraries.

    Raises:
        GpsecError: a file of the scenario is missing or wrong.
    """
    configuration = scenario.model_dump(mode="json", exclude=_WITHOUT_EFFECT)
    digest = hashlib.sha256(json.dumps(configuration, sort_keys=True).encode())
    for argument in sumo_options(scenario).arguments:
        for name in argument.split(","):
            # Where a file lies makes no difference, only what is in it.
            files = [Path(name)] if Path(name).is_absolute() else []
            contents = [_file(path) for path in input_files(files)]
            digest.update(b"".join(contents) if contents else name.encode())
    for content in _outside(scenario):
        digest.update(content.encode())
    for tape in (scenario.fleet.camera.tape, scenario.fleet.gnss.tape):
        if tape is not None:
            digest.update(load_tape(tape)[1].encode())
        digest.update(b";")
    if scenario.fleet.camera.source == "image":
        from gpsec.imaging.pictures.opencv import opencv  # late: no other run needs it

        digest.update(f"opencv {opencv().__version__}".encode())
    if scenario.detection.models is not None:
        digest.update(_folder(Path(scenario.detection.models)))
    for part in _environment():
        digest.update(part)
    return digest.hexdigest()


def environment_digest() -> str:
    """Return a digest of all that a fingerprint has in common with those of other scenarios: code and libraries."""
    return hashlib.sha256(b"".join(_environment())).hexdigest()


def _environment() -> Iterator[bytes]:
    for name, installed in {**versions(), "Python": platform.python_version(), "machine": platform.machine()}.items():
        yield f"{name} {installed}".encode()
    yield _package()


def _outside(scenario: Scenario) -> Iterator[str]:
    """Yield the digests of the parts from outside gpsec: those that the scenario names, and installed ones in use."""
    yield from (parts.part_digest(reference) for reference in scenario.parts)
    used: tuple[tuple[Registry[Any], Iterable[str]], ...] = (
        (ATTACKS, [plan.attack for plan in scenario.plans]),
        (DETECTORS, [*scenario.detection.detectors, *(defence.detector for defence in scenario.defences)]),
        (RESPONSES, [defence.response for defence in scenario.defences]),
        (PROFILES, scenario.fleet.profile),
        (REACTIONS, reactions_of(scenario.closed_loop)),
        (DYNAMICS, [scenario.closed_loop.dynamics]),
    )
    for registry, names in used:
        yield from (parts.installed_digest(registry, name) for name in names)


def versions() -> dict[str, str]:
    """Return the installed version of each of `PACKAGES`."""
    return {package: _installed(package, version) for package in PACKAGES}


@cache
def _installed(package: str, read: Callable[[str], str]) -> str:
    """Return what `read` says; to ask takes three milliseconds, and a list of many runs asks for each."""
    return read(package)


def _file(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").digest()
    except OSError as error:
        raise GpsecError(f"{path}: cannot be read: {error.strerror}") from None


@cache
def _package() -> bytes:
    """Return the digest of the code and the models of gpsec that a run is made with."""
    return _folder(Path(__file__).resolve().parents[1])


def _folder(folder: Path) -> bytes:
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder)
        if path.suffix in (".py", ".npz", ".json") and name.parts[0].removesuffix(".py") not in _BESIDE:
            digest.update(name.as_posix().encode())
            digest.update(_file(path))
    return digest.digest()

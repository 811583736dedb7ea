"""What the bytes of a run depend on, as one number: two runs of the same fingerprint have the same tables."""

import hashlib
import json
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from gpsec.kernels import ABOVE
from gpsec.scenario import Scenario
from gpsec.scenario.traffic import sumo_options

# Settings that change what a run costs, and nothing in its tables.
_WITHOUT_EFFECT: dict[str, Any] = {"sumocfg": True, "threads": True, "detection": {"models"}}
# Layers that start runs or read their tables.
_BESIDE = ABOVE - {"engine", "pipeline", "reference", "scenario"}
_PACKAGES = ("libsumo", "numpy", "numba", "pandas", "pyproj", "shapely")


def fingerprint(scenario: Scenario) -> str:
    """Return a digest of the configuration, the files that SUMO reads, the code, the models and the libraries.

    Raises:
        GpsecError: a file of the scenario is missing or wrong.
    """
    configuration = scenario.model_dump(mode="json", exclude=_WITHOUT_EFFECT)
    digest = hashlib.sha256(json.dumps(configuration, sort_keys=True).encode())
    for argument in sumo_options(scenario).arguments:
        for name in argument.split(","):
            path = Path(name)
            # Where a file lies makes no difference, only what is in it.
            digest.update(_file(path) if path.is_absolute() and path.is_file() else name.encode())
    if scenario.detection.models is not None:
        digest.update(_folder(Path(scenario.detection.models)))
    for package in _PACKAGES:
        digest.update(f"{package} {version(package)}".encode())
    digest.update(_package())
    return digest.hexdigest()


def _file(path: Path) -> bytes:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").digest()


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

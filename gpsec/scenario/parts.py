"""Parts that a user brings along: a class of a module or of a file, or a sensor profile in TOML.

To load a class is to run code. Who names it on the command line, or calls `use`, has chosen it; a scenario file may
have come from somebody else, which `gpsec.scenario.outside` minds.
"""

import hashlib
import importlib
import sys
import tomllib
from collections.abc import Callable, Iterable
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

from pydantic import ValidationError

from gpsec.attacks.registry import ATTACKS
from gpsec.core import sources
from gpsec.core.errors import GpsecError, shown
from gpsec.core.registry import Registry
from gpsec.detection.registry import DETECTORS
from gpsec.localization.registry import RESPONSES
from gpsec.sensors.profiles import SensorProfile
from gpsec.sensors.registry import PROFILES
from gpsec.steering.registry import DYNAMICS, REACTIONS

REGISTRIES: tuple[Registry[Any], ...] = (ATTACKS, DETECTORS, RESPONSES, PROFILES, DYNAMICS, REACTIONS)
EXPECTED = "expected FILE.py:Name, package.module:Name, or a sensor profile FILE.toml"

_used: dict[str, str] = {}


def is_code(reference: str) -> bool:
    """Return whether loading a reference runs code."""
    return not reference.endswith(".toml")


def relocate(reference: str, move: Callable[[str], str]) -> str:
    """Return a reference with the path of its file, if it has one, changed by `move`.

    Raises:
        GpsecError: it is none.
    """
    place, colon, name = reference.rpartition(":") if is_code(reference) else (reference, "", "")
    if is_code(reference) and not (place and name.isidentifier()):
        raise GpsecError(f"part '{shown(reference)}': {EXPECTED}")
    if not place.endswith((".py", ".toml")):
        return reference
    return f"{move(place)}{colon}{name}"


def use(references: Iterable[str]) -> None:
    """Load parts, so that they can be named like those of gpsec; what is loaded already is left as it is.

    Raises:
        GpsecError: one cannot be loaded, is no part, or has the name of another one.
    """
    for reference in references:
        if reference in _used:
            continue
        made = _load(reference)
        names = [name for registry in REGISTRIES if (name := registry.add(made, reference)) is not None]
        if not names:
            kinds = ", ".join(registry.kind for registry in REGISTRIES)
            raise GpsecError(f"part '{shown(reference)}': expected one of {kinds} with a name, found {shown(made)}")
        _used[reference] = names[0]


def in_use(reference: str) -> bool:
    """Return whether a part has been loaded."""
    return reference in _used


def used_name(reference: str) -> str:
    """Return the name of a part that has been loaded."""
    return _used[reference]


def part_digest(reference: str) -> str:
    """Return what changes with the content of a part: of its file, or of the package that its module belongs to.

    Raises:
        GpsecError: the file cannot be read.
    """
    place = reference.rpartition(":")[0] if is_code(reference) else reference
    if place.endswith((".py", ".toml")):
        return hashlib.sha256(_content(Path(place), reference)).hexdigest()
    return sources.digest(sources.owner(place)) or ""


def installed_digest(registry: Registry[Any], name: str) -> str:
    """Return what changes with the code of a part of an installed package, empty where the part is gpsec's own."""
    module = registry.module_of(name)
    return (sources.digest(sources.owner(module)) or "") if module else ""


def _load(reference: str) -> Any:
    if not is_code(reference):
        return _profile(Path(reference))
    place, _, name = reference.rpartition(":")
    module = _file_module(Path(place), reference) if place.endswith(".py") else _module(place, reference)
    try:
        return getattr(module, name)
    except AttributeError:
        raise GpsecError(f"part '{shown(reference)}': {shown(place)} has no '{shown(name)}'") from None


def _module(name: str, reference: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except Exception as error:
        raise _unusable(reference, error) from error


def _file_module(path: Path, reference: str) -> ModuleType:
    """Return the module of a file; its name tells which, so that its classes can be found again by it."""
    content = _content(path, reference)
    name = f"gpsec_part_{hashlib.sha256(str(path).encode() + content).hexdigest()[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise GpsecError(f"part '{shown(reference)}': {EXPECTED}")
    module = module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise _unusable(reference, error) from error
    return module


def _unusable(reference: str, error: Exception) -> GpsecError:
    return GpsecError(f"part '{shown(reference)}': cannot be imported: {type(error).__name__}: {shown(error)}")


def _content(path: Path, reference: str) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise GpsecError(f"part '{shown(reference)}': cannot be read: {error.strerror}") from None


def _profile(path: Path) -> SensorProfile:
    """Return the sensor profile in a file of TOML; its name is the file's where it does not say another one."""
    try:
        told = tomllib.loads(_content(path, str(path)).decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise GpsecError(f"{path}: not valid TOML: {shown(error)}") from None
    try:
        return SensorProfile.model_validate({"name": path.stem, "title": f"from {path.name}", **told})
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        key = ".".join(str(part) for part in first["loc"])
        if first["type"] == "missing":
            raise GpsecError(f"{path}: {shown(key)} is missing") from None
        said = first["msg"].removeprefix("Value error, ")
        raise GpsecError(f"{path}: {shown(key)}: {shown(said)}, found {shown(repr(first['input']))}") from None

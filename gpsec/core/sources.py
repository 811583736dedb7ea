"""Which sources a kept result depends on: those of the layer that makes it, and of all that this layer may import."""

import hashlib
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from secrets import token_hex

_PACKAGE = Path(__file__).parents[1]
# Layers that start runs, join the stages or read tables, and what is for files of other kinds or for pictures.
ABOVE = frozenset(
    [
        "cli",
        "console",
        "report",
        "paper",
        "running",
        "sweeps",
        "testing",
        "training",
        "imaging",
        "replay",
        "pipeline",
        "reference",
        "scenario",
        "openstreetmap",
        "opendrive",
        "demand",
    ]
)
STAGES = frozenset(
    [
        "traffic",
        "sensors",
        "attacks",
        "association",
        "detection",
        "localization",
        "steering",
        "encounters",
        "outcomes",
    ]
)
# As the import contracts in pyproject.toml have it, from the top: a layer imports those of the ranks below its own, and
# itself. What is not here is a basic, which all may import.
RANKS = (ABOVE, STAGES, frozenset(["hdmap"]), frozenset(["filters"]), frozenset(["types"]))

# The state of sources when the first kernel of their layer was met, which is when they were imported.
_noticed: dict[Path, list[tuple[int, int]]] = {}


def page_digest() -> str:
    """Return the SHA-256, in hexadecimal, of what packs Plotly's script for a page."""
    return _digest_of(_PACKAGE / "report" / "page").hex()


def owner(module: str) -> str:
    """Return what owns a module: a layer, such as ``gpsec.detection``, or the package of somebody else."""
    return ".".join(module.split(".")[: 2 if module.startswith("gpsec.") else 1])


def covered(layer: str) -> list[str]:
    """Return the modules and packages directly in gpsec that `layer` may import, and itself.

    For a package of somebody else, that is all but the layers above the stages.
    """
    own = layer.removeprefix("gpsec.") if layer.startswith("gpsec.") else ""
    found = {path.stem for path in _PACKAGE.iterdir() if path.suffix == ".py" or (path / "__init__.py").is_file()}
    basics = {name for name in found if _rank(name) == len(RANKS)}
    return sorted(basics | {name for name in found if name == own or _rank(name) > (_rank(own) if own else 0)})


def _rank(name: str) -> int:
    return next((number for number, layers in enumerate(RANKS) if name in layers), len(RANKS))


@cache
def digest(layer: str) -> str | None:
    """Return the SHA-256, in hexadecimal, of all sources that what is compiled in `layer` can depend on.

    The layer is one that `owner` gives. Where its sources lie makes no difference. Sources that were changed since they
    were noticed have a number that nothing else has, since this process has read others. None: they cannot be found, as
    those of a script.
    """
    if not layer.startswith("gpsec.") and not _places(layer):
        return None
    total = hashlib.sha256()
    for place in _all_places(layer):
        total.update(_digest_of(place))
    return total.hexdigest() if are_unchanged(layer) else token_hex(32)


@cache
def notice(layer: str) -> None:
    """Remember the state of the sources of a layer: what is compiled later is of these."""
    for place in _all_places(layer):
        if place not in _noticed:
            _noticed[place] = _state(place)


def are_unchanged(layer: str) -> bool:
    """Return whether the sources of a layer are as they were noticed."""
    return all(_noticed.get(place, now) == now for place in _all_places(layer) for now in [_state(place)])


def _all_places(layer: str) -> list[Path]:
    own = [] if layer.startswith("gpsec.") else _places(layer)
    return [_PACKAGE / name for name in covered(layer)] + own


def _places(package: str) -> list[Path]:
    """Return the folders of a package, or its only file without the suffix."""
    spec = find_spec(package) if package.isidentifier() and not package.startswith("__") else None
    if spec is None:
        return []
    if spec.submodule_search_locations:
        return [Path(folder) for folder in spec.submodule_search_locations]
    return [Path(spec.origin).with_suffix("")] if spec.origin and spec.origin.endswith(".py") else []


@cache
def _digest_of(place: Path) -> bytes:
    """Return the digest of all sources of a package, or of the module of that name."""
    total = hashlib.sha256()
    for path in _files(place):
        total.update(path.relative_to(place.parent).as_posix().encode() + b"\0")
        total.update(hashlib.sha256(path.read_bytes()).digest())
    return total.digest()


def _files(place: Path) -> list[Path]:
    found = sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
    return [path for path in found if path.is_file()]  # no link that an editor locks a file with


def _state(place: Path) -> list[tuple[int, int]]:
    return [(info.st_mtime_ns, info.st_size) for info in map(Path.stat, _files(place))]

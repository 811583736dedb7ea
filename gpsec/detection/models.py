"""What was trained and calibrated, as files without pickle: arrays in .npz, thresholds and provenance in JSON."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError, shown
from gpsec.core.npz import DamagedError, read_npz
from gpsec.core.version import __version__
from gpsec.detection.base import Detector, LabelledDetector
from gpsec.detection.calibration import Calibrated, nearest_rates
from gpsec.detection.gate import GATED_BY, Thresholds, gate_of
from gpsec.detection.learned import Learned
from gpsec.detection.registry import DETECTORS
from gpsec.types.constants import MODELLED

FORMAT = 2
_THRESHOLDS, _PROVENANCE = "thresholds.json", "provenance.json"
_RETRAIN = "run 'gpsec train' to make it, and name its folder as detection.models"


@dataclass(frozen=True)
class ProfileModel:
    """What belongs to one sensor profile and association.

    Attributes:
        learned: arrays by detector.
        thresholds: by false-alarm rate and detector.
        provenance: what it was made of and how, as plain JSON.
    """

    learned: Mapping[str, Learned]
    thresholds: Thresholds
    provenance: Mapping[str, Any] = field(default_factory=dict)


# profile, association
Models = Mapping[tuple[str, str], ProfileModel]


def save(models: Models, folder: Path) -> None:
    """Write models into `folder`, each file whole or not at all, the same bytes for the same models.

    The thresholds know the digest of the arrays that they were calibrated with, and each of the files in JSON that of
    what it says, so that files that were changed, or that do not belong together, are not taken for a model.
    """
    folder.mkdir(parents=True, exist_ok=True)
    digests: dict[str, str] = {}
    thresholds: dict[str, Any] = {}
    provenance: dict[str, Any] = {}
    for (profile, association), model in sorted(models.items()):
        arrays = {f"{detector}.{key}": a for detector, one in model.learned.items() for key, a in one.items()}
        stream = BytesIO()
        np.savez_compressed(stream, **dict(sorted(arrays.items())))  # type: ignore[arg-type]
        _write(folder / _file(profile, association), stream.getvalue())
        digests[_file(profile, association)] = hashlib.sha256(stream.getvalue()).hexdigest()
        thresholds.setdefault(profile, {})[association] = {
            rate: {name: None if found is None else _stated(found) for name, found in sorted(by_detector.items())}
            for rate, by_detector in model.thresholds.items()
        }
        provenance.setdefault(profile, {})[association] = dict(model.provenance)
    _write(folder / _THRESHOLDS, _as_json({"arrays": digests, "models": thresholds}))
    _write(folder / _PROVENANCE, _as_json({"models": provenance}))


def _stated(found: Calibrated) -> dict[str, Any]:
    """Return a threshold as plain JSON: without an interval where it has none, and marked where it is a model's."""
    said: dict[str, Any] = {"threshold": found.threshold, "achieved": found.achieved}
    if found.lo is not None and found.hi is not None:
        said |= {"lo": found.lo, "hi": found.hi}
    return said | ({"model": True} if found.model else {})


def load_models(folder: Path | None = None) -> Models:
    """Return all models of `folder`, or those that gpsec comes with; arrays are read when a detector is built.

    Raises:
        GpsecError: a file is missing or damaged.
    """
    root: Traversable = files("gpsec") / "models" if folder is None else folder
    thresholds = _read_json(root / _THRESHOLDS)
    provenance = _part(_read_json(root / _PROVENANCE), "models", root / _PROVENANCE)
    digests = _part(thresholds, "arrays", root / _THRESHOLDS)
    models = {}
    for profile, by_association in _part(thresholds, "models", root / _THRESHOLDS).items():
        made_of = provenance.get(profile, {})
        if not isinstance(by_association, dict) or not isinstance(made_of, dict):
            raise GpsecError(f"{root / _THRESHOLDS}: {profile}: expected association -> rate; {_RETRAIN} again")
        for association, by_rate in by_association.items():
            source = f"{root / _THRESHOLDS}: {profile}.{association}"
            file = _file(profile, association)
            models[profile, association] = ProfileModel(
                _LazyArrays(root / file, str(digests.get(file))),
                _check_thresholds(by_rate, source),
                _part(made_of, association, root / _PROVENANCE) if association in made_of else {},
            )
    return models


@cache
def bundled() -> Models:
    """Return the models that gpsec comes with."""
    return load_models()


def build_detectors(
    names: Sequence[str], profiles: Sequence[str], association: str, models: Models | None = None
) -> list[Detector | LabelledDetector]:
    """Return one detector for each name; it serves rows of all `profiles`, told apart by `Observation.profile`.

    Raises:
        GpsecError: an unknown name, or no usable model for a profile.
    """
    detectors = []
    for name in names:
        entry = DETECTORS[name]
        learned: list[Learned] = []
        source = name if entry.learn is not None else entry.learns_from
        if source is not None:
            for profile in profiles:
                arrays = _of(models, profile, association).learned
                if source not in arrays:
                    raise GpsecError(
                        f"model of profile '{profile}', association '{association}': no {source}; {_RETRAIN}"
                    )
                learned.append(arrays[source])
        detectors.append(entry.build(learned))
    return detectors


def thresholds_for(
    points: Sequence[tuple[str, str]], profiles: Sequence[str], association: str, models: Models | None = None
) -> Floats:
    """Return (P, K) thresholds for each profile of `points`: a detector with a false-alarm rate such as "0.1/h".

    Raises:
        GpsecError: an unknown name or rate, or one that the calibration data could not tell.
    """
    table = np.empty((len(profiles), len(points)))
    for p, profile in enumerate(profiles):
        for k, (name, rate) in enumerate(points):
            fixed = DETECTORS[name].threshold
            table[p, k] = _threshold(_of(models, profile, association), profile, rate, name) if fixed is None else fixed
    return table


def gates_for(profiles: Sequence[str], association: str, models: Models | None = None) -> Floats:
    """Return the (P,) gate of the monitor for each profile.

    Raises:
        GpsecError: there is no usable model for a profile, or none of the detector whose threshold it is.
    """
    gates = []
    for profile in profiles:
        gate = gate_of(_of(models, profile, association).thresholds)
        if gate is None:
            raise GpsecError(
                f"model of profile '{profile}', association '{association}': no threshold of {GATED_BY}, which is the"
                f" gate of the monitor; {_RETRAIN}"
            )
        gates.append(gate)
    return np.array(gates)


def _threshold(model: ProfileModel, profile: str, rate: str, name: str) -> float:
    if not any(name in row for row in model.thresholds.values()):
        raise GpsecError(f"thresholds of profile '{profile}': no {name}; {_RETRAIN}")
    found = model.thresholds.get(rate, {}).get(name)
    if found is None:
        known = [r for r, row in model.thresholds.items() if row.get(name) is not None]
        raise GpsecError(
            f"false-alarm rate '{shown(rate)}' of {name}, profile '{profile}': there was too little benign data to"
            f" calibrate it: {nearest_rates(rate, known)}; 'gpsec calibrate' has more"
        )
    return found.threshold


def _of(models: Models | None, profile: str, association: str) -> ProfileModel:
    available = bundled() if models is None else models
    key = profile, association if association in MODELLED else MODELLED[0]
    if key not in available:
        raise GpsecError(
            f"no model for sensor profile '{shown(profile)}' with {association} association; run 'gpsec train"
            f" --profile {shown(profile)}' (and --part, if the profile comes by it), and name its folder as"
            " detection.models"
        )
    return available[key]


class _LazyArrays(Mapping[str, Learned]):
    """The arrays of a file, read at first use and checked as a whole, against their digest."""

    def __init__(self, source: Traversable, digest: str) -> None:
        self._source = source
        self._digest = digest
        self._content: dict[str, dict[str, np.ndarray]] | None = None

    def _read(self) -> dict[str, dict[str, np.ndarray]]:
        if self._content is None:
            try:
                packed = self._source.read_bytes()
                if hashlib.sha256(packed).hexdigest() != self._digest:
                    raise DamagedError(f"it is not the one that {_THRESHOLDS} beside it was made with")
                flat = read_npz(BytesIO(packed))
            except FileNotFoundError:
                raise GpsecError(f"{self._source}: no such file; {_RETRAIN}") from None
            except (OSError, DamagedError) as error:
                raise GpsecError(f"{self._source}: damaged ({shown(error)}); {_RETRAIN} again") from None
            content: dict[str, dict[str, np.ndarray]] = {}
            for name, array in flat.items():
                detector, _, key = name.partition(".")
                content.setdefault(detector, {})[key] = array
            self._content = content
        return self._content

    def __getitem__(self, detector: str) -> Learned:
        return self._read()[detector]

    def __iter__(self) -> Any:
        return iter(self._read())

    def __len__(self) -> int:
        return len(self._read())


def _file(profile: str, association: str) -> str:
    return f"{profile}-{association}.npz"


def _write(path: Path, content: bytes) -> None:
    partial = path.with_name(f".{path.name}.partial")
    partial.write_bytes(content)
    partial.replace(path)


def _as_json(content: Mapping[str, Any]) -> bytes:
    """Return the text of a file: what it says, who wrote it, and its digest."""
    said = {"format": FORMAT, "gpsec_version": __version__, **content}
    return (json.dumps({**said, "digest": _digest(said)}, indent=2, allow_nan=False) + "\n").encode()


def _digest(said: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()


def _read_json(source: Traversable) -> dict[str, Any]:
    """Return what `_as_json` has written.

    Raises:
        GpsecError: it is missing, damaged, of another format, or was changed since.
    """
    try:
        said = json.loads(source.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise GpsecError(f"{source}: no such file; {_RETRAIN}") from None
    except (OSError, ValueError, RecursionError) as error:
        raise GpsecError(f"{source}: damaged ({shown(error)}); {_RETRAIN} again") from None
    found = said.get("format") if isinstance(said, dict) else None
    if found != FORMAT:
        raise GpsecError(f"{source}: expected models of format {FORMAT}, found format {shown(found)}; {_RETRAIN} again")
    content: dict[str, Any] = said
    if content.pop("digest", None) != _digest(content):
        raise GpsecError(f"{source}: damaged (it was changed since it was written); {_RETRAIN} again")
    return content


def _part(said: Mapping[str, Any], key: str, source: Traversable) -> dict[str, Any]:
    found = said.get(key)
    if not isinstance(found, dict):
        raise GpsecError(f"{source}: expected names and values under '{key}'; {_RETRAIN} again")
    return found


def _calibrated(said: Mapping[str, Any]) -> Calibrated:
    low, high = (None if said.get(key) is None else float(said[key]) for key in ("lo", "hi"))
    return Calibrated(float(said["threshold"]), float(said["achieved"]), low, high, said.get("model") is True)


def _check_thresholds(by_rate: Any, source: str) -> Thresholds:
    checked: dict[str, dict[str, Calibrated | None]] = {}
    try:
        for rate, by_detector in by_rate.items():
            checked[rate] = {name: None if one is None else _calibrated(one) for name, one in by_detector.items()}
        if any(one is not None and one.threshold != one.threshold for row in checked.values() for one in row.values()):
            raise ValueError("not a number")
    except (AttributeError, KeyError, TypeError, ValueError):
        raise GpsecError(f"{source}: expected rate -> detector -> threshold and achieved; {_RETRAIN} again") from None
    return checked

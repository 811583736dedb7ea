"""What was trained and calibrated, as files without pickle: arrays in .npz, thresholds and provenance in JSON."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from gpsec.arrays import Floats
from gpsec.detection.base import Detector, LabelledDetector
from gpsec.detection.calibration import Calibrated
from gpsec.detection.learned import Learned
from gpsec.detection.registry import DETECTORS
from gpsec.errors import GpsecError, nearest, shown

MATCHINGS = ("tracked", "nearest")
FORMAT = 1
_THRESHOLDS, _PROVENANCE = "thresholds.json", "provenance.json"
_RETRAIN = "run 'gpsec train' to make it"

# rate -> detector -> threshold, None where there was too little data
Thresholds = Mapping[str, Mapping[str, Calibrated | None]]


@dataclass(frozen=True)
class ProfileModel:
    """What belongs to one sensor profile and matching.

    Attributes:
        learned: arrays by detector.
        thresholds: by false-alarm rate and detector.
        provenance: what it was made of and how, as plain JSON.
    """

    learned: Mapping[str, Learned]
    thresholds: Thresholds
    provenance: Mapping[str, Any] = field(default_factory=dict)


# profile, matching
Models = Mapping[tuple[str, str], ProfileModel]


def save(models: Models, folder: Path) -> None:
    """Write models into `folder`, each file whole or not at all, the same bytes for the same models."""
    folder.mkdir(parents=True, exist_ok=True)
    thresholds: dict[str, Any] = {}
    provenance: dict[str, Any] = {}
    for (profile, matching), model in sorted(models.items()):
        arrays = {f"{detector}.{key}": a for detector, one in model.learned.items() for key, a in one.items()}
        stream = BytesIO()
        np.savez_compressed(stream, **dict(sorted(arrays.items())))  # type: ignore[arg-type]
        _write(folder / _file(profile, matching), stream.getvalue())
        thresholds.setdefault(profile, {})[matching] = {
            rate: {
                name: None if found is None else {"threshold": found.threshold, "achieved": found.achieved}
                for name, found in sorted(by_detector.items())
            }
            for rate, by_detector in model.thresholds.items()
        }
        provenance.setdefault(profile, {})[matching] = dict(model.provenance)
    for name, content in ((_THRESHOLDS, thresholds), (_PROVENANCE, provenance)):
        text = json.dumps({"format": FORMAT, "models": content}, indent=2, allow_nan=False) + "\n"
        _write(folder / name, text.encode())


def load(folder: Path | None = None) -> Models:
    """Return all models of `folder`, or those that gpsec comes with; arrays are read when a detector is built.

    Raises:
        GpsecError: a file is missing or damaged.
    """
    root: Traversable = files("gpsec") / "models" if folder is None else folder
    thresholds = _read_json(root / _THRESHOLDS)
    provenance = _read_json(root / _PROVENANCE)
    models = {}
    for profile, by_matching in thresholds.items():
        if not isinstance(by_matching, dict) or not isinstance(provenance.get(profile, {}), dict):
            raise GpsecError(f"{root / _THRESHOLDS}: {profile}: expected matching -> rate; {_RETRAIN} again")
        for matching, by_rate in by_matching.items():
            source = f"{root / _THRESHOLDS}: {profile}.{matching}"
            models[profile, matching] = ProfileModel(
                _LazyArrays(root / _file(profile, matching)),
                _check_thresholds(by_rate, source),
                provenance.get(profile, {}).get(matching, {}),
            )
    return models


@cache
def bundled() -> Models:
    """Return the models that gpsec comes with."""
    return load()


def build_detectors(
    names: Sequence[str], profiles: Sequence[str], matching: str, models: Models | None = None
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
                arrays = _of(models, profile, matching).learned
                if source not in arrays:
                    raise GpsecError(f"model of profile '{profile}', matching '{matching}': no {source}; {_RETRAIN}")
                learned.append(arrays[source])
        detectors.append(entry.build(learned))
    return detectors


def thresholds_for(
    names: Sequence[str], profiles: Sequence[str], matching: str, rate: str, models: Models | None = None
) -> Floats:
    """Return (P, K) thresholds of the detectors `names` for each profile at a false-alarm rate such as "1e-3/sample".

    Raises:
        GpsecError: an unknown name or rate, or one that the calibration data could not tell.
    """
    table = np.empty((len(profiles), len(names)))
    for p, profile in enumerate(profiles):
        for k, name in enumerate(names):
            fixed = DETECTORS[name].threshold
            table[p, k] = _threshold(_of(models, profile, matching), profile, rate, name) if fixed is None else fixed
    return table


def _threshold(model: ProfileModel, profile: str, rate: str, name: str) -> float:
    if rate not in model.thresholds:
        raise GpsecError(f"unknown false-alarm rate '{shown(rate)}': {nearest(rate, model.thresholds)}")
    by_detector = model.thresholds[rate]
    if name not in by_detector:
        raise GpsecError(f"thresholds of profile '{profile}': no {name}; {_RETRAIN}")
    found = by_detector[name]
    if found is None:
        known = [r for r, row in model.thresholds.items() if row.get(name) is not None]
        raise GpsecError(
            f"false-alarm rate '{shown(rate)}' of {name}, profile '{profile}': there was too little benign data to"
            f" calibrate it; calibrated: {', '.join(known) or 'none'}"
        )
    return found.threshold


def _of(models: Models | None, profile: str, matching: str) -> ProfileModel:
    available = bundled() if models is None else models
    if (profile, matching) not in available:
        names = sorted(f"{p}/{m}" for p, m in available)
        raise GpsecError(f"no model for '{profile}/{matching}': {nearest(f'{profile}/{matching}', names)}; {_RETRAIN}")
    return available[profile, matching]


class _LazyArrays(Mapping[str, Learned]):
    """The arrays of a file, read at first use and checked as a whole."""

    def __init__(self, source: Traversable) -> None:
        self._source = source
        self._content: dict[str, dict[str, np.ndarray]] | None = None

    def _read(self) -> dict[str, dict[str, np.ndarray]]:
        if self._content is None:
            try:
                with np.load(BytesIO(self._source.read_bytes()), allow_pickle=False) as archive:
                    flat = {name: archive[name] for name in archive.files}
            except FileNotFoundError:
                raise GpsecError(f"{self._source}: no such file; {_RETRAIN}") from None
            except (OSError, ValueError, EOFError, KeyError, BadZipFile, AttributeError) as error:
                raise GpsecError(f"{self._source}: damaged ({error}); {_RETRAIN} again") from None
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


def _file(profile: str, matching: str) -> str:
    return f"{profile}-{matching}.npz"


def _write(path: Path, content: bytes) -> None:
    partial = path.with_name(f".{path.name}.partial")
    partial.write_bytes(content)
    partial.replace(path)


def _read_json(source: Traversable) -> dict[str, Any]:
    try:
        document = json.loads(source.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise GpsecError(f"{source}: no such file; {_RETRAIN}") from None
    except (OSError, ValueError) as error:
        raise GpsecError(f"{source}: damaged ({error}); {_RETRAIN} again") from None
    found = document.get("format") if isinstance(document, dict) else None
    if found != FORMAT or not isinstance(document.get("models"), dict):
        raise GpsecError(f"{source}: expected models of format {FORMAT}, found format {found}; {_RETRAIN} again")
    content: dict[str, Any] = document["models"]
    return content


def _check_thresholds(by_rate: Any, source: str) -> Thresholds:
    checked: dict[str, dict[str, Calibrated | None]] = {}
    try:
        for rate, by_detector in by_rate.items():
            checked[rate] = {
                name: None if one is None else Calibrated(float(one["threshold"]), float(one["achieved"]))
                for name, one in by_detector.items()
            }
        if any(one is not None and one.threshold != one.threshold for row in checked.values() for one in row.values()):
            raise ValueError("not a number")
    except (AttributeError, KeyError, TypeError, ValueError):
        raise GpsecError(f"{source}: expected rate -> detector -> threshold and achieved; {_RETRAIN} again") from None
    return checked

"""Trains and calibrates every detector on benign runs."""

from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from importlib.metadata import version
from typing import Any

from gpsec.core.threads import Threads
from gpsec.detection.base import Detector
from gpsec.detection.calibration import RATES, Calibrated, thresholds_by_rate
from gpsec.detection.gate import GATED_BY, with_gate
from gpsec.detection.learned import Learned, OnStage, silent
from gpsec.detection.logs import Grid, ResidualLog
from gpsec.detection.models import ProfileModel
from gpsec.detection.registry import DETECTORS

SETTLE_S = 10.0
_PACKAGES = ("gpsec", "numpy", "numba", "scikit-learn", "torch")


def train_one(
    training: Sequence[ResidualLog],
    calibration: Sequence[ResidualLog],
    seed: int = 1,
    settle_s: float = SETTLE_S,
    progress: OnStage = silent,
    threads: Threads | None = None,
    detectors: Sequence[str] = DETECTORS.own,
) -> ProfileModel:
    """Train on the one, calibrate on the other set of logs, both of one profile and matching.

    `detectors` are those that are trained and calibrated, each behind the one whose arrays it is built of. Those that
    read the monitor are calibrated behind the gate that the same benign runs give it, for which `joint` is among them.

    Raises:
        GpsecError: there are too few vehicles, or the logs do not belong together.
    """
    learned: dict[str, Learned] = {}
    thresholds: dict[str, dict[str, Calibrated | None]] = {rate: {} for rate in RATES}
    settings: dict[str, Any] = {}
    grid = Grid.of(calibration)
    gate: dict[str, Calibrated | None] = {}
    if any(DETECTORS[name].reads_monitor for name in detectors):
        progress("gate of the monitor", 0, 1)
        grid, gate = with_gate(grid, settle_s, threads)
    for name in detectors:
        entry = DETECTORS[name]
        arrays: list[Learned] = []
        if entry.learn is not None:
            learned[name] = entry.learn(training, seed, progress)
            arrays = [learned[name]]
        elif entry.learns_from is not None:
            arrays = [learned[entry.learns_from]]
        detector = entry.build(arrays)
        if not isinstance(detector, Detector) or entry.threshold is not None:
            continue
        settings[name] = _settings(detector)
        found = thresholds_by_rate(detector, grid, settle_s, progress, threads)
        if name == GATED_BY:
            found |= gate
        for rate, one in found.items():
            thresholds[rate][name] = one
    provenance = {
        "seed": seed,
        "settle_s": settle_s,
        "training": _describe(training),
        "calibration": _describe(calibration),
        "detectors": settings,
        "versions": {package: version(package) for package in _PACKAGES},
    }
    return ProfileModel(learned, thresholds, provenance)


def related(names: Sequence[str]) -> tuple[str, ...]:
    """Return detectors with all that share arrays or the monitor's gate with them, in the order of their training.

    Raises:
        GpsecError: there is no detector of such a name.
    """
    sources = {DETECTORS[name].learns_from or name for name in names}
    gated = any(DETECTORS[name].reads_monitor for name in names)
    return tuple(
        name
        for name, entry in DETECTORS.items()
        if (entry.learns_from or name) in sources or (gated and entry.reads_monitor)
    )


def merged(former: ProfileModel | None, latter: ProfileModel) -> ProfileModel:
    """Return a model with what `latter` has, and what it has not from `former`; provenance says which is which."""
    if former is None:
        return latter
    settings, kept = latter.provenance["detectors"], former.provenance.get("detectors", {})
    rates = {rate: {**former.thresholds.get(rate, {}), **found} for rate, found in latter.thresholds.items()}
    provenance = dict(latter.provenance)
    if others := sorted(set(kept) - set(settings)):
        provenance |= {"detectors": {**kept, **settings}, "kept": {"detectors": others, "from": _origin(former)}}
        if rare := {name: of for name, of in former.provenance.get("rare", {}).items() if name in others}:
            provenance["rare"] = rare
    return ProfileModel({**former.learned, **latter.learned}, rates, provenance)


def _origin(model: ProfileModel) -> dict[str, Any]:
    return {key: value for key, value in model.provenance.items() if key not in ("detectors", "kept")}


def _settings(detector: Detector) -> dict[str, Any]:
    """Return the hyper-parameters: plain numbers and tuples of them, not the arrays."""
    if not is_dataclass(detector):
        return {}
    values = {field.name: getattr(detector, field.name) for field in fields(detector)}
    return {key: value for key, value in values.items() if key != "learned"}


def _describe(logs: Sequence[ResidualLog]) -> dict[str, Any]:
    return {
        "networks": sorted({log.network for log in logs}),
        "vehicles": sum(len(set(log.vehicle.tolist())) for log in logs),
        "samples": sum(len(log.vehicle) for log in logs),
        "valid_samples": sum(int(log.valid.sum()) for log in logs),
        "vehicle_hours": round(sum(len(log.vehicle) * log.step_s for log in logs) / 3600.0, 3),
    }

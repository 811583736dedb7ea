"""Calibration of rare false-alarm rates: recorded benign traffic, sensed again and again with new noise."""

import hashlib
import json
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.processes import check_may_start
from gpsec.core.threads import cores
from gpsec.detection.base import Detector
from gpsec.detection.calibration import Calibrated
from gpsec.detection.gate import gate_of
from gpsec.detection.learned import Learned
from gpsec.detection.logs import Grid
from gpsec.detection.models import Models, ProfileModel, build_detectors, gates_for, load_models, save
from gpsec.detection.rare import RARE, GatedHarvest, Harvest
from gpsec.detection.registry import DETECTORS
from gpsec.detection.training import SETTLE_S
from gpsec.scenario.networks import TRAINING_NETWORKS
from gpsec.scenario.outside import load_parts
from gpsec.scenario.parts import use
from gpsec.sensors.registry import PROFILES
from gpsec.training.collect import residual_log
from gpsec.training.pool import Pool, TrainingProgress, tell_progress
from gpsec.training.recordings import Recordings
from gpsec.training.tapes import TrainingTapes
from gpsec.training.train_models import CALIBRATION_RUNS

HOURS = 1000.0
# Noise of the k-th time that traffic is sensed has the traffic's seed plus k of these: `gpsec train` has k = 0.
NEW_NOISE = 1000


@dataclass(frozen=True)
class RareJob:
    """One model whose rare rates are calibrated.

    Attributes:
        profile, association: which model.
        model: what was learned, with its arrays read.
        detectors: whose thresholds are wanted.
        hours: of benign driving, at least.
        traffic: recordings.
        seeds: of the traffic.
        parts: from outside gpsec.
        tapes: that its sensors play, by name.
    """

    profile: str
    association: str
    model: ProfileModel
    detectors: tuple[str, ...]
    hours: float
    traffic: Recordings
    seeds: tuple[int, ...]
    parts: tuple[str, ...]
    tapes: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name in the progress display."""
        return f"{self.profile}/{self.association}"


def calibrate(
    out: Path | str = "models",
    *,
    hours: float = HOURS,
    detectors: Sequence[str] = (),
    profiles: Sequence[str] = (),
    parts: Sequence[str] = (),
    tapes: Sequence[str] = (),
    jobs: int | None = None,
    report: Callable[[TrainingProgress], None] | None = None,
) -> tuple[str, ...]:
    """Calibrate the rates of 0.1 an hour and rarer of trained models, and write each as soon as it is done.

    The traffic is that of calibration, not of training; every time that it is sensed, the noise is new. What a model
    has been calibrated on in as many hours already is left as it is, so that an interrupted run goes on.

    Args:
        out: folder of the models, as `gpsec.train` wrote it.
        hours: of benign driving for each model, at least.
        detectors: names; none stands for all that the models have.
        profiles: names of sensor profiles; none stands for all that the models have.
        parts: detectors and profiles from outside gpsec, see `gpsec.train`.
        tapes: those that the models were trained with.
        jobs: number of processes; None takes one for each core.
        report: called in this process with how far each of them is.

    Returns:
        ``profile/association`` of the models that were calibrated anew.

    Raises:
        GpsecError: there are no models, none of that profile or detector, or they were trained with other tapes.
    """
    check_may_start()
    try:
        loaded = load_parts(parts, Path(), allow_code=True)
    except ValueError as error:
        raise GpsecError(f"parts: {error}") from None
    played = TrainingTapes.of(tapes)
    models = {key: replace(model, learned=dict(model.learned)) for key, model in load_models(Path(out)).items()}
    _check_known("profile", profiles, [profile for profile, _ in models], Path(out))
    known = [name for model in models.values() for name in model.thresholds.get("1/h", {})]
    _check_known("detector", detectors, known, Path(out))
    with tempfile.TemporaryDirectory(prefix="gpsec-calibrate-") as name:
        pool = Pool(jobs or cores(), Path(name), report or _ignore)
        chosen = (tuple(detectors), tuple(profiles), loaded, tuple(tapes))
        work = _work(models, chosen, hours, pool.folder)
        if not work:
            return ()
        for job in work:
            played.check_same(job.model.provenance.get("tapes", {}), job.name)
        work[0].traffic.record({seed for job in work for seed in job.seeds}, pool)

        def keep(place: int, found: Mapping[str, Mapping[str, Calibrated | None]]) -> None:
            job = work[place]
            key = job.profile, job.association
            models[key] = with_rare(models[key], found, hours)
            save(models, Path(out))

        pool.run("thresholds", [(job.name, rare_job, (job,)) for job in work], keep)
        return tuple(job.name for job in work)


def with_rare(model: ProfileModel, found: Mapping[str, Mapping[str, Calibrated | None]], hours: float) -> ProfileModel:
    """Return a model with thresholds detector -> rate -> threshold; its provenance says what they were made of."""
    rates = {}
    for rate in RARE:
        former = model.thresholds.get(rate, {})
        # What these hours do not tell, such as the rate of a score that has an upper end, stays as fewer hours told it.
        kept = {} if RARE[rate].model else former
        rates[rate] = {**former, **{name: by_rate[rate] or kept.get(name) for name, by_rate in found.items()}}
    model = replace(model, thresholds={**model.thresholds, **rates})
    rare = {name: {"hours": hours, "of": digest_of(model, name)} for name in found}
    return replace(model, provenance={**model.provenance, "rare": {**model.provenance.get("rare", {}), **rare}})


def digest_of(model: ProfileModel, detector: str) -> str:
    """Return what changes with what a detector has learned, with its parameters and with the gate that it is behind."""
    learned: Learned = model.learned.get(DETECTORS[detector].learns_from or detector, {})
    told = hashlib.sha256(json.dumps(model.provenance.get("detectors", {}).get(detector), sort_keys=True).encode())
    for key in sorted(learned):
        told.update(key.encode() + learned[key].tobytes())
    if DETECTORS[detector].reads_monitor:
        told.update(repr(gate_of(model.thresholds)).encode())
    return told.hexdigest()


def rare_job(job: RareJob) -> dict[str, dict[str, Calibrated | None]]:
    """Return the thresholds of a model's detectors, detector -> rate -> threshold."""
    use(job.parts)
    profile = PROFILES[job.profile]
    own = {(job.profile, job.association): job.model}
    built = build_detectors(job.detectors, [job.profile], job.association, own)
    kept = [Harvest(detector, SETTLE_S) for detector in built if isinstance(detector, Detector)]
    plain = [harvest for harvest in kept if not harvest.detector.reads_monitor]
    gated = GatedHarvest([harvest for harvest in kept if harvest.detector.reads_monitor])
    runs = [(network, seed) for seed in job.seeds for network in job.traffic.nets]
    watched, tapes = bool(gated.harvests), TrainingTapes.of(job.tapes)
    gate = float(gates_for([job.profile], job.association, own)[0]) if watched else 0.0
    time = 0
    while kept and kept[0].hours < job.hours:
        time += 1
        for number, (network, seed) in enumerate(runs):
            tell_progress(job.name, f"{kept[0].hours:.0f} of {job.hours:.0f} vehicle-hours", *_part(kept[0], job))
            recording = job.traffic.read(network, seed)
            noise = seed + time * NEW_NOISE
            played = tapes.of_run(number, profile, float(recording.step_s[0]))
            net = job.traffic.nets[network]
            log = residual_log(recording, net, network, profile, job.association, noise, watched, played)
            grid = Grid.of([log])
            for harvest in plain:
                harvest.take(grid)
            if watched:
                gated.take(grid)
    found = {}
    for harvest in plain:
        tell_progress(job.name, f"thresholds of {harvest.detector.name}", *_part(harvest, job))
        found[harvest.detector.name] = harvest.calibrated()
    if watched:
        tell_progress(job.name, "thresholds of the monitor's detectors", *_part(gated.harvests[0], job))
        found |= gated.calibrated(gate)
    return found


def _part(harvest: Harvest, job: RareJob) -> tuple[int, int]:
    return min(int(harvest.hours), int(job.hours)), int(job.hours)


def _work(
    models: Models,
    chosen: tuple[tuple[str, ...], ...],
    hours: float,
    folder: Path,
) -> list[RareJob]:
    """Return what is left to do."""
    detectors, profiles, parts, tapes = chosen
    recordings = Recordings.of(TRAINING_NETWORKS, folder)
    work = []
    for (profile, association), model in sorted(models.items()):
        if profiles and profile not in profiles:
            continue
        known = tuple(model.thresholds.get("1/h", {}))
        left = {name for name in known if (not detectors or name in detectors) and not _done(model, name, hours)}
        gated = any(DETECTORS[name].reads_monitor for name in left)
        # The gate is found anew, and all that are behind it with it.
        names = tuple(name for name in known if name in left or (gated and DETECTORS[name].reads_monitor))
        if names:
            first = (1 + CALIBRATION_RUNS) * int(model.provenance.get("seed", 1))
            seeds = tuple(range(first + 1, first + 1 + CALIBRATION_RUNS))
            work.append(RareJob(profile, association, model, names, hours, recordings, seeds, parts, tapes))
    return work


def _done(model: ProfileModel, detector: str, hours: float) -> bool:
    said: Mapping[str, Any] = model.provenance.get("rare", {}).get(detector, {})
    return bool(said) and said["hours"] >= hours and said["of"] == digest_of(model, detector)


def _check_known(kind: str, names: Sequence[str], known: Sequence[str], out: Path) -> None:
    for name in names:
        if name not in known:
            raise GpsecError(f"{out}: no model of {kind} '{shown(name)}': {nearest(name, list(dict.fromkeys(known)))}")


def _ignore(progress: TrainingProgress) -> None:
    return

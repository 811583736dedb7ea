"""Training: benign traffic, residuals of every profile and association, learning, calibration."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.processes import check_may_start
from gpsec.core.threads import cores
from gpsec.detection.logs import ResidualLog
from gpsec.detection.models import ProfileModel, bundled, load_models, save
from gpsec.detection.registry import DETECTORS
from gpsec.detection.training import SETTLE_S, merged, related, train_one
from gpsec.scenario.networks import TRAINING_NETWORKS
from gpsec.scenario.outside import load_parts
from gpsec.scenario.parts import use
from gpsec.sensors.registry import PROFILES
from gpsec.training.collect import residual_log
from gpsec.training.pool import Pool, TrainingProgress, tell_progress
from gpsec.training.recordings import Recordings
from gpsec.training.tapes import TrainingTapes
from gpsec.types.constants import MODELLED

# Runs of each network that thresholds are calibrated on: with all networks, enough for 0.1 false alarms an hour.
CALIBRATION_RUNS = 3


@dataclass(frozen=True)
class Job:
    """One profile and matching.

    Attributes:
        profile, association: what is trained.
        seed: of noise and training.
        traffic: recordings.
        training_seed, calibration_seeds: of the traffic.
        detectors: those that are trained and calibrated.
        parts: from outside gpsec.
        tapes: that its sensors play, by name.
    """

    profile: str
    association: str
    seed: int
    traffic: Recordings
    training_seed: int
    calibration_seeds: tuple[int, ...]
    detectors: tuple[str, ...] = DETECTORS.own
    parts: tuple[str, ...] = ()
    tapes: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name in the progress display."""
        return f"{self.profile}/{self.association}"


class Driving(NamedTuple):
    """The benign driving that detectors are trained on.

    Attributes:
        networks: some of `TRAINING_NETWORKS`.
        tapes: that sensors play in the place of their profile's noise, by name or file; of several of one kind, one run
            after the other takes the next.
        associations: how vehicles know their lane: some of `MODELLED`.
    """

    networks: Sequence[str] = TRAINING_NETWORKS
    tapes: Sequence[str] = ()
    associations: Sequence[str] = MODELLED


@dataclass(frozen=True)
class Wanted:
    """What is trained.

    Attributes:
        networks: of `TRAINING_NETWORKS`.
        profiles: sensor profiles; none stands for all of gpsec's own.
        detectors: with those that share arrays with them; none stands for all of gpsec's own.
        parts: from outside gpsec, by their references with whole paths, loaded already.
        tapes: that sensors play, by name; none stands for the profiles' own noise.
        associations: of `MODELLED`.
    """

    networks: Sequence[str] = TRAINING_NETWORKS
    profiles: Sequence[str] = ()
    detectors: Sequence[str] = ()
    parts: tuple[str, ...] = ()
    tapes: tuple[str, ...] = ()
    associations: tuple[str, ...] = MODELLED

    def resolved(self) -> tuple[list[str], tuple[str, ...], tuple[str, ...]]:
        """Return networks, profiles and detectors, in the order in which they are trained.

        Raises:
            GpsecError: there is none of such a name.
        """
        for network in self.networks:
            if network not in TRAINING_NETWORKS:
                raise GpsecError(f"no training network '{shown(network)}': {nearest(network, TRAINING_NETWORKS)}")
        networks = [network for network in TRAINING_NETWORKS if network in self.networks]
        profiles = tuple(PROFILES[name].name for name in self.profiles) or PROFILES.own
        return networks, profiles, related(self.detectors) if self.detectors else DETECTORS.own


_ALL_NETWORKS = Driving()


def train(
    out: Path | str = "models",
    *,
    detectors: Sequence[str] = (),
    profiles: Sequence[str] = (),
    driving: Driving = _ALL_NETWORKS,
    parts: Sequence[str] = (),
    seed: int = 1,
    jobs: int | None = None,
    report: Callable[[TrainingProgress], None] | None = None,
) -> tuple[str, ...]:
    """Train detectors on the training networks, calibrate their thresholds, and write each model as soon as it is done.

    Detectors learn on the traffic of one seed and are calibrated on that of the `CALIBRATION_RUNS` after it. The files
    depend on the seed and on what is wanted, and not on the number of processes. What is not trained is taken from the
    models that `out` holds, else, where all networks are trained on, from those that gpsec comes with. A run uses them
    by ``detection={"models": out}``. Nothing is printed; a script needs no ``if __name__ == "__main__"``.

    Args:
        out: folder of the models; new, empty, or with models.
        detectors: names; those that share arrays with them are trained too. None stands for all of gpsec's own.
        profiles: names of sensor profiles. None stands for all of gpsec's own.
        driving: what they are trained on; all training networks, where it is not given.
        parts: detectors and profiles from outside gpsec that are loaded: `FILE.py:Name`, `package.module:Name`, or
            `FILE.toml`.
        seed: of traffic, noise and training.
        jobs: number of processes; None takes one for each core.
        report: called in this process with how far each of them is.

    Returns:
        ``profile/association`` of the models that were trained.

    Raises:
        GpsecError: there is no such network, profile, detector or tape, a part cannot be loaded, or `out` holds
            something else than models.
    """
    check_may_start()
    try:
        loaded = load_parts(parts, Path(), allow_code=True)
    except ValueError as error:
        raise GpsecError(f"parts: {error}") from None
    TrainingTapes.of(driving.tapes)  # before anything is simulated
    wanted = Wanted(driving.networks, profiles, detectors, loaded, tuple(driving.tapes), tuple(driving.associations))
    with tempfile.TemporaryDirectory(prefix="gpsec-train-") as name:
        pool = Pool(jobs or cores(), Path(name), report or _ignore)
        return tuple(job.name for job in _train(wanted, Path(out), seed, pool))


def _train(wanted: Wanted, out: Path, seed: int, pool: Pool) -> list[Job]:
    networks, profiles, detectors = wanted.resolved()
    models = _former(out, whole=len(networks) == len(TRAINING_NETWORKS))
    first = (1 + CALIBRATION_RUNS) * seed
    seeds = range(first, first + 1 + CALIBRATION_RUNS)
    recordings = Recordings.of(networks, pool.folder)
    recordings.record(seeds, pool)
    lasting = (detectors, wanted.parts, wanted.tapes)
    work = [
        Job(profile, association, seed, recordings, seeds[0], tuple(seeds[1:]), *lasting)
        for profile in profiles
        for association in wanted.associations
    ]

    def keep(place: int, model: ProfileModel) -> None:
        key = work[place].profile, work[place].association
        models[key] = merged(models.get(key), model)
        save(models, out)

    pool.run("models", [(job.name, train_job, (job,)) for job in work], keep)
    return work


def _ignore(progress: TrainingProgress) -> None:
    return


def _former(out: Path, *, whole: bool) -> dict[tuple[str, str], ProfileModel]:
    """Return the models that what is not trained is taken from, with their arrays read."""
    found = load_models(out) if out.is_dir() and any(out.iterdir()) else bundled() if whole else {}
    return {key: replace(model, learned=dict(model.learned)) for key, model in found.items()}


def train_job(job: Job) -> ProfileModel:
    """Sense the recorded traffic with one profile and association, train and calibrate."""
    use(job.parts)
    profile = PROFILES[job.profile]
    watched = any(DETECTORS[name].reads_monitor for name in job.detectors)
    tapes = TrainingTapes.of(job.tapes)

    def logs(*seeds: int, watched: bool = False) -> list[ResidualLog]:
        runs = [(network, seed) for seed in seeds for network in job.traffic.nets]
        collected = []
        for done, (network, seed) in enumerate(runs):
            tell_progress(job.name, "sensing", done, len(runs))
            recording = job.traffic.read(network, seed)
            played = tapes.of_run(done, profile, float(recording.step_s[0]))
            net = job.traffic.nets[network]
            collected.append(residual_log(recording, net, network, profile, job.association, seed, watched, played))
        return collected

    def progress(stage: str, done: int, total: int) -> None:
        tell_progress(job.name, stage, done, total)

    training, calibration = logs(job.training_seed), logs(*job.calibration_seeds, watched=watched)
    model = train_one(training, calibration, job.seed, SETTLE_S, progress, detectors=job.detectors)
    return replace(model, provenance={**model.provenance, "tapes": tapes.digests}) if job.tapes else model

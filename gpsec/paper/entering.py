"""What `gpsec bench-detector` does with one detector: tries it, trains and calibrates it, and runs the suite."""

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pandas as pd

from gpsec.core.errors import GpsecError, nearest, shown
from gpsec.core.progress import Report
from gpsec.detection.models import bundled, load_models
from gpsec.detection.registry import DETECTORS
from gpsec.outcomes.state import OutcomeState
from gpsec.outcomes.study import Study
from gpsec.outcomes.view import StepView
from gpsec.paper.leaderboard import suite_rows
from gpsec.paper.runs import RUNS, run_missing
from gpsec.paper.suite import Candidate, Suite, suite_runs
from gpsec.paper.tryout import TryOut, check_statistics, try_out
from gpsec.pipeline.run import run_scenario
from gpsec.scenario import Scenario
from gpsec.scenario.choices import BOUNDS
from gpsec.scenario.parts import part_digest, used_name
from gpsec.training import Driving, TrainingProgress, calibrate, train
from gpsec.training.pool import Pool
from gpsec.training.recordings import Recordings
from gpsec.training.train_models import CALIBRATION_RUNS
from gpsec.types.constants import MODELLED
from gpsec.types.vehicles import Identity

_SEED = 1
TellTraining = Callable[[TrainingProgress], None]


@dataclass(frozen=True)
class Entrant:
    """A detector that enters the suite.

    Attributes:
        name: of the detector.
        parts: its reference with the whole path, where it is no part of gpsec.
        profile: sensor profile that it is benchmarked with.
        suite: that it is put through.
        out: folder of all detectors that are benchmarked together.
    """

    name: str
    parts: tuple[str, ...]
    profile: str
    suite: Suite
    out: Path

    @property
    def folder(self) -> Path:
        """Folder of what it has learned and of its runs; another one when its code changes."""
        mark = "".join(f"-{part_digest(part)[:8]}" for part in self.parts)
        return self.out / f"{self.name}{mark}-{self.profile}-{self.suite.name}"

    @property
    def candidate(self) -> Candidate:
        """The detector with what it has learned."""
        return Candidate(self.name, self.parts, self.folder / "models" if self.parts else None, self.profile)


def entrant_name(reference: str, loaded: str | None) -> str:
    """Return the name of a detector: of a shipped one, or of a part that was `loaded`.

    Raises:
        GpsecError: it is no detector that can be benchmarked.
    """
    name = reference if loaded is None else used_name(loaded)
    known = [one for one in DETECTORS.own if one not in BOUNDS]
    if loaded is None and name not in known:
        raise GpsecError(f"no detector '{shown(name)}': {nearest(name, known)}; one of yours is FILE.py:Name")
    if name not in DETECTORS:
        raise GpsecError(f"{shown(reference)}: expected a detector, found another part, '{shown(name)}'")
    return name


def check_profile_known(profile: str) -> None:
    """Refuse a sensor profile that gpsec has no models of.

    Raises:
        GpsecError: there are none.
    """
    known = {name for name, _ in bundled()}
    if profile not in known:
        raise GpsecError(
            f"--profile {shown(profile)}: expected one that gpsec has models of: {nearest(profile, known)}"
        )


def qualify(entrant: Entrant, jobs: int, tell: TellTraining) -> float:
    """Try a detector, and train and calibrate it where it is no part of gpsec; return its µs a track-step.

    What has been learned and calibrated in its folder already is left as it is.

    Raises:
        GpsecError: the detector fails, answers what is no statistic, or takes too long.
    """
    suite = entrant.suite
    entrant.folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="gpsec-try-") as name:
        pool = Pool(1, Path(name), tell)
        network, seed = suite.training[0], (1 + CALIBRATION_RUNS) * _SEED
        traffic = Recordings.of([network], pool.folder)
        traffic.record([seed], pool)
        wanted = TryOut(entrant.name, entrant.parts, entrant.profile, traffic, network, seed)
        (cost_us,) = pool.run("try-out", [(entrant.name, try_out, (wanted,))])
    if entrant.parts:
        _learn(entrant, jobs, tell)
    return float(cost_us)


def _learn(entrant: Entrant, jobs: int, tell: TellTraining) -> None:
    suite, folder = entrant.suite, entrant.folder / "models"
    chosen = {"detectors": (entrant.name,), "profiles": (entrant.profile,), "parts": entrant.parts}
    if not _is_trained(entrant, folder):
        driving = Driving(suite.training, associations=MODELLED[:1])
        train(folder, driving=driving, seed=_SEED, jobs=jobs, report=tell, **chosen)
    if suite.hours:
        calibrate(folder, hours=suite.hours, jobs=jobs, report=tell, **chosen)
    thresholds = load_models(folder)[entrant.profile, MODELLED[0]].thresholds
    for rate in suite.rates:
        if thresholds.get(rate, {}).get(entrant.name) is None:
            raise GpsecError(
                f"detector '{entrant.name}': expected a threshold at {rate}, found none: its statistic does not tell"
                " such rare alarms apart"
            )


def _is_trained(entrant: Entrant, folder: Path) -> bool:
    if not folder.is_dir() or not any(folder.iterdir()):
        return False
    model = load_models(folder).get((entrant.profile, MODELLED[0]))
    return model is not None and entrant.name in model.thresholds.get("1/h", {})


def count_runs(entrant: Entrant) -> int:
    """Return how many runs the suite has."""
    return sum(map(len, suite_runs(entrant.suite, entrant.candidate).values()))


def run_suite(entrant: Entrant, cost_us: float, jobs: int, report: Report) -> pd.DataFrame:
    """Run what is missing of the suite; return the rows of the detector.

    Raises:
        GpsecError: the detector answers what is no statistic; what has been run is kept.
    """
    runs = suite_runs(entrant.suite, entrant.candidate)
    every = [scenario for members in runs.values() for scenario in members]
    run_missing(every, entrant.folder / RUNS, jobs, report, watched_run)
    folders: Mapping[str, list[Path]] = {
        world: [entrant.folder / RUNS / scenario.name for scenario in members] for world, members in runs.items()
    }
    return suite_rows(entrant.suite, entrant.candidate, folders, cost_us)


def watched_run(scenario: Scenario, folder: Path, report: Report) -> None:
    """Run a scenario of the suite, and end it at the first answer of its detector that is no statistic.

    Raises:
        GpsecError: there is one, or the scenario cannot be run.
    """
    run_scenario(scenario, folder, report, onlooker=_Watcher(scenario.detection.detectors[0]))


class _Watcher:
    """Looks at every statistic of a run; implements `gpsec.pipeline.interfaces.Onlooker`."""

    def __init__(self, name: str) -> None:
        self._check = partial(check_statistics, name)
        self._columns: list[int] = []
        self._name = name

    def begin(self, study: Study) -> None:
        self._columns = [at for at, name in enumerate(study.detectors) if name.partition("@")[0] == self._name]

    def see(self, view: StepView, outcomes: OutcomeState, fleet: Mapping[int, Identity]) -> None:
        self._check(view.answers.statistic[view.rows][:, self._columns], view.time_s)

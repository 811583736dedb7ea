"""`gpsec dataset`: residuals, fixes, camera, truth and labels of the suite's traffic, for models made without gpsec."""

import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from gpsec.core import shipped
from gpsec.core.errors import GpsecError
from gpsec.core.progress import Report
from gpsec.outcomes.naming import base_name, seeded_name
from gpsec.outcomes.tables import whole
from gpsec.paper.dataset_card import card, provenance_of
from gpsec.paper.dataset_log import DatasetLog
from gpsec.paper.runs import run_missing
from gpsec.paper.suite import STANDARD, blind_plans
from gpsec.pipeline.run import run_scenario
from gpsec.running.workshop import Workshop
from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.detection import Defence
from gpsec.scenario.load import changed
from gpsec.scenario.networks import TRAINING_NETWORKS
from gpsec.scenario.overrides import Override
from gpsec.training.train_models import CALIBRATION_RUNS

CARD, STATED = "README.md", "dataset.json"
_FILE = "steps-of-dataset.parquet"
# Seeds of gpsec's own training, so that what is learned here has seen what gpsec's detectors have.
_SEEDS = {"train": (1 + CALIBRATION_RUNS,), "calibration": tuple(range(2 + CALIBRATION_RUNS, 2 + 2 * CALIBRATION_RUNS))}


@dataclass(frozen=True)
class Export:
    """What is exported.

    Attributes:
        profile: sensor profile of the fleet.
        duration_s: simulated time of each run; None for all that a training network has, and the suite's of the others.
        networks: only these; none stands for all.
    """

    profile: str
    duration_s: float | None = None
    networks: tuple[str, ...] = ()

    def runs(self) -> dict[str, list[Scenario]]:
        """Return the runs of each split."""
        found = {split: list(self._benign(split, seeds)) for split, seeds in _SEEDS.items()}
        return found | {"test": list(self._attacked())}

    def _benign(self, split: str, seeds: tuple[int, ...]) -> Iterator[Scenario]:
        for network in self._chosen(TRAINING_NETWORKS):
            for seed in seeds:
                yield self._run(network, seed, {"name": seeded_name(f"{network}-{split}", seed), "plans": ()})

    def _attacked(self) -> Iterator[Scenario]:
        for network in self._chosen(STANDARD.networks):
            for seed in STANDARD.seeds:
                own = {"name": seeded_name(f"{network}-test", seed), "plans": blind_plans()}
                yield self._run(network, seed, {"duration_s": STANDARD.duration_s, **own})

    def _chosen(self, networks: tuple[str, ...]) -> list[str]:
        return [network for network in networks if not self.networks or network in self.networks]

    def _run(self, network: str, seed: int, update: Mapping[str, object]) -> Scenario:
        keys = [Override(("fleet", key), value, f"fleet.{key}") for key, value in self._fleet().items()]
        found = changed(load_scenario(shipped.scenarios() / network), keys)
        told = {
            "seed": seed,
            "defences": (Defence(detector="never", response="none"),),
            "detection": found.detection.model_copy(update={"detectors": ("chi_square",)}),
            "outcomes": found.outcomes.model_copy(update={"bootstrap": 10}),
            **update,
        }
        return found.model_copy(update=told | ({"duration_s": self.duration_s} if self.duration_s else {}))

    def _fleet(self) -> dict[str, object]:
        return {"profile": self.profile, "equipped_share": 1.0}


def check_empty(out: Path) -> None:
    """Refuse a folder that holds anything.

    Raises:
        GpsecError: it does, or it is no folder.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        found = "one with files" if out.is_dir() else "a file"
        raise GpsecError(f"{out}: expected an empty or new folder for a dataset, found {found}; choose another one")


def make_dataset(export: Export, out: Path, work: Workshop, jobs: int, report: Report) -> Path:
    """Run what is missing in the workshop, and put the dataset into `out`; return its data card.

    Raises:
        GpsecError: a run fails, or the disk refuses; what has been run is kept in the workshop.
        KeyboardInterrupt: the user has had enough; likewise.
    """
    work.kept = True
    runs = export.runs()
    every = [scenario for members in runs.values() for scenario in members]
    run_missing(every, work.folder, jobs, report, logged_run)
    files: dict[str, list[Path]] = {}
    for split, members in runs.items():
        for scenario in members:
            network = base_name(scenario.name).removesuffix(f"-{split}")
            target = out / split / f"{network}-{scenario.seed}.parquet"
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(work.folder / scenario.name / _FILE, target)
            files.setdefault(split, []).append(target)
    told = provenance_of(export.profile, runs, files, out)
    for name, text in ((STATED, told), (CARD, card(export.profile, runs, files))):
        with whole(out / name) as partial:
            partial.write_text(text, "utf-8")
    work.kept = False
    return out / CARD


def logged_run(scenario: Scenario, folder: Path, report: Report) -> None:
    """Run a scenario, and keep a row of every track and step beside its tables.

    Raises:
        GpsecError: the scenario cannot be run.
    """
    with DatasetLog(folder / _FILE) as log:
        run_scenario(scenario, folder, report, onlooker=log)

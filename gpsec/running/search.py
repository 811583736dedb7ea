"""The worst attack on one defence: plans are proposed, many are tried in one replayed simulation, and told apart.

Two samplers have the same budget: TPE (Bergstra et al., NeurIPS 2011) as Optuna has it, and random draws, which it has
to be better than. What the search itself measures of its best plan is too high, since it was chosen for it; so the
best plans are judged on noise and on traffic that the search has not seen.
"""

import json
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pandas as pd

from gpsec.attacks.plans import PlanConfig
from gpsec.core.errors import GpsecError, shown
from gpsec.core.progress import DONE, Progress, Report
from gpsec.outcomes.tables import FLOAT_FORMAT, read_table, whole, write_frame
from gpsec.pipeline.run import run_scenario
from gpsec.running.replayed import Stage
from gpsec.running.search_score import harm, judged_figures
from gpsec.running.search_space import Space
from gpsec.running.workshop import LOCK
from gpsec.scenario import Scenario
from gpsec.scenario.detection import Defence
from gpsec.types.points import detector_at

TRIALS, RESULT, SETTINGS = "trials.csv", "search.csv", "search.json"
SAMPLERS = ("tpe", "random")
Trial = dict[str, Any]
_TRAFFIC = "traffic"
# Seeds of SUMO that are held out lie so far from that of the search.
AWAY = 1000


@dataclass(frozen=True)
class WorstCase:
    """What is searched for.

    Attributes:
        scenario: its traffic and its fleet.
        defence: that is attacked.
        space: of the plans.
        objective: `out_of_lane` or `line_touched`, the share of attacked vehicles that the attack brings there and
            their benign twins do not come to; or `undetected`, the median of the largest error of the undefended
            estimate before an alarm.
        plans: that each sampler tries.
        together: of them in one simulation.
        held_out: seeds of noise, and of traffic, that the best plans are judged on.
    """

    scenario: Scenario
    defence: Defence
    space: Space
    objective: str = "out_of_lane"
    plans: int = 64
    together: int = 16
    held_out: int = 4

    def stated(self) -> dict[str, Any]:
        """Return what the result depends on, as JSON has it."""
        free = {one.name: list(one.ends) for one in self.space.free}
        return {
            "scenario": self.scenario.stated(),
            "defence": self.defence.name,
            "attack": self.space.attack,
            "free": free,
            "fixed": dict(self.space.fixed),
            "objective": self.objective,
            "plans": self.plans,
            "together": self.together,
            "held_out": self.held_out,
        }


def optuna() -> ModuleType:
    """Return Optuna, which does not say what it does.

    Raises:
        GpsecError: it is not installed.
    """
    try:
        import optuna
    except ImportError as error:
        raise GpsecError(
            f"a search needs the extra 'search' (pip install 'gpsec[search]'), found no Optuna: {error}"
        ) from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return optuna


def run_search(search: WorstCase, out: Path, report: Report) -> pd.DataFrame:
    """Search what is missing in `out`, judge the best, and write and return the table of the result.

    Raises:
        GpsecError: the scenario cannot be run, or `out` has another search.
    """
    optuna()
    _claim(search, out)
    trials = _known(search, out)
    report(Progress(_TRAFFIC, stage="recording"))
    stage = Stage(search.scenario)
    report(Progress(_TRAFFIC, stage=DONE))
    done = len(trials) // (len(SAMPLERS) * search.together)
    for batch in range(_batches(search)):
        if batch >= done:
            trials += _batch(search, stage, batch, trials, report)
            with whole(out / TRIALS) as partial:
                write_frame(pd.DataFrame(trials), partial)
        report(Progress(f"batch {batch}", stage=DONE))
    table = _judged(search, stage, trials, report)
    with whole(out / RESULT) as partial:
        write_frame(table, partial)
    return table


def tasks_of(search: WorstCase) -> int:
    """Return how many tasks a search tells of: the recording of its traffic, and its simulations."""
    return 1 + _batches(search) + 2 * search.held_out


def _batches(search: WorstCase) -> int:
    return -(-search.plans // search.together)


def _batch(search: WorstCase, stage: Stage, batch: int, trials: Sequence[Trial], report: Report) -> list[Trial]:
    """Return the trials of a batch: as many plans of each sampler, in one simulation."""
    proposed = [
        {"batch": batch, "sampler": sampler, **values}
        for sampler in SAMPLERS
        for values in _proposals(search, sampler, batch, trials)
    ]
    names = [one.name for one in search.space.free]
    plans = [search.space.plan(f"plan_{at}", {key: row[key] for key in names}) for at, row in enumerate(proposed)]
    events = _events(search, stage, search.scenario.seed, plans, _telling(report, f"batch {batch}"))
    scores = [harm(events[events["attack"] == plan.name], search.defence.name, search.objective) for plan in plans]
    return [row | {"score": _as_written(value)} for row, value in zip(proposed, scores, strict=True)]


def _as_written(value: Any) -> Any:
    """Return a value as it will be read again, so that a search that goes on knows no more than one that began."""
    return float(FLOAT_FORMAT % value) if isinstance(value, float) else value


def _claim(search: WorstCase, out: Path) -> None:
    """Note in `out` what is searched, or see that it is the same as is noted there."""
    stated, path = json.dumps(search.stated(), indent=2, sort_keys=True) + "\n", out / SETTINGS
    if path.is_file():
        if path.read_text("utf-8") != stated:
            raise GpsecError(f"{path}: expected the same search as before, found another one; choose another --out")
        return
    if out.is_dir() and any(path.name != LOCK for path in out.iterdir()):
        raise GpsecError(f"{out}: expected an empty folder, or that of this search, found other files")
    with whole(path) as partial:
        partial.write_text(stated, "utf-8")


def _known(search: WorstCase, out: Path) -> list[Trial]:
    """Return the trials of the batches that are done."""
    path = out / TRIALS
    if not path.is_file():
        return []
    names = ["batch", "sampler", *(one.name for one in search.space.free), "score"]
    try:
        table = pd.read_csv(path)
    except (OSError, ValueError) as error:
        raise GpsecError(f"{path}: expected the trials of a search, found other data ({shown(error)})") from None
    size = len(SAMPLERS) * search.together
    if list(table.columns) != names or len(table) % size or table.isna().any(axis=None):
        raise GpsecError(f"{path}: expected whole batches of {size} trials with {', '.join(names)}, found others")
    return [{str(name): value for name, value in row.items()} for row in table.astype(object).to_dict("records")]


def _proposals(search: WorstCase, sampler: str, batch: int, trials: Sequence[Trial]) -> Iterator[Trial]:
    """Yield the plans that a sampler tries next, from what is known of its own.

    It begins anew in every batch, from the trials and a seed, so that a search that goes on is one that never stopped.
    """
    library = optuna()
    seed = (search.scenario.seed * 1_000 + batch) % 2**32
    if sampler == "random":
        chosen = library.samplers.RandomSampler(seed=seed)
    else:
        with warnings.catch_warnings(action="ignore"):  # that plans of one batch know of each other is experimental
            chosen = library.samplers.TPESampler(seed=seed, constant_liar=True, n_startup_trials=search.together)
    study = library.create_study(direction="maximize", sampler=chosen)
    spaces = search.space.distributions(library)
    for row in trials:
        if row["sampler"] == sampler:
            values = {name: row[name] for name in spaces}
            study.add_trial(library.trial.create_trial(params=values, distributions=spaces, value=row["score"]))
    for _ in range(search.together):
        yield {name: _as_written(value) for name, value in study.ask(spaces).params.items()}


def _events(search: WorstCase, stage: Stage, seed: int, plans: Sequence[PlanConfig], report: Report) -> pd.DataFrame:
    """Return the events of plans, tried in one simulation with the noise of a seed."""
    found = search.scenario
    known = [one for one in (plan.parameters.known() for plan in plans) if one is not None]
    detection = found.detection
    if all(one.targets for one in known):  # detectors that nobody heeds cost time
        heeded = {search.defence.detector, *(detector_at(target) for one in known for target in one.targets)}
        scored = tuple(name for name in detection.detectors if name in heeded)
        detection = detection.model_copy(update={"detectors": scored})
    update = {
        "seed": seed,
        "plans": tuple(plans),
        "defences": tuple(dict.fromkeys((Defence(detector="never", response="none"), search.defence))),
        "detection": detection,
        "outcomes": found.outcomes.model_copy(update={"bootstrap": 10}),
    }
    with tempfile.TemporaryDirectory() as folder:
        run_scenario(found.model_copy(update=update), Path(folder), report, start=stage.start)
        return read_table(Path(folder), "events")


def _telling(report: Report, name: str) -> Report:
    """Return what tells of a simulation under a name, without its notes, which are the same each time."""
    return lambda progress: report(replace(progress, scenario=name, note=""))


def _judged(search: WorstCase, stage: Stage, trials: Sequence[Trial], report: Report) -> pd.DataFrame:
    """Return a row for the best of each sampler and for the defaults, on noise and on traffic that were held out."""
    names = [one.name for one in search.space.free]
    best = {
        name: max((row for row in trials if row["sampler"] == name), key=lambda row: float(row["score"]))
        for name in SAMPLERS
    }
    values: dict[str, Trial] = {"default": {}}
    values |= {name: {key: row[key] for key in names} for name, row in best.items()}
    plans = {who: search.space.plan(who, chosen) for who, chosen in values.items()}
    found: dict[str, list[pd.DataFrame]] = {"other noise": [], "other traffic": []}
    for where, parts in found.items():
        for number in range(1, search.held_out + 1):
            name, seed = f"{where} {number}", search.scenario.seed + number
            other = stage
            if where == "other traffic":
                seed += AWAY
                other = Stage(search.scenario.model_copy(update={"seed": seed}))
            events = _events(search, other, seed, list(plans.values()), _telling(report, name))
            parts.append(events.assign(run=number))
            report(Progress(name, stage=DONE))
    rows = []
    for who, plan in plans.items():
        stated = json.dumps({name: getattr(plan.parameters, name) for name in names})
        head = {"plan": who, "parameters": stated, "searched_score": best[who]["score"] if who in best else np.nan}
        for where, parts in found.items():
            mine = pd.concat([part[part["attack"] == who] for part in parts], ignore_index=True)
            rows.append(head | {"judged_on": where} | judged_figures(mine, search.defence.name, search.scenario.seed))
    return pd.DataFrame(rows)

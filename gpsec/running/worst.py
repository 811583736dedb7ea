"""The plan `worst` of a run: the worst attack that a search has found, on seeds that the search has not seen."""

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from gpsec.attacks.plans import PlanConfig, plan_config
from gpsec.core.errors import GpsecError, shown
from gpsec.running.search import AWAY, RESULT, SETTINGS
from gpsec.running.search_score import JUDGED_BY
from gpsec.scenario import Scenario

WORST = "worst"


@dataclass(frozen=True)
class FoundWorst:
    """What a search has found.

    Attributes:
        plan: the worst of its plans on what it has held out, called `worst`.
        scenario: name of the scenario that was searched.
        seeds: that the search has used, of noise or of traffic.
    """

    plan: PlanConfig
    scenario: str
    seeds: tuple[int, ...]

    def into(self, scenario: Scenario, seeds: Collection[int]) -> Scenario:
        """Return a scenario with this plan beside its own, which is to be run with these seeds.

        Raises:
            GpsecError: it has a plan of that name, or one of the seeds is known to the search.
        """
        if any(plan.name == WORST for plan in scenario.plans):
            raise GpsecError(f"scenario '{scenario.name}': --worst: expected no plan called '{WORST}', found one")
        known = [seed for seed in seeds if seed in self.seeds and scenario.name == self.scenario]
        if known:
            raise GpsecError(
                f"--worst: expected a seed that the search has not seen ({', '.join(map(str, self.seeds))}), found"
                f" {known[0]}: on its own seeds its best looks worse than it is; give --seed {max(self.seeds) + 1}"
            )
        return scenario.model_copy(update={"plans": (*scenario.plans, self.plan)})


def read_worst(folder: Path) -> FoundWorst:
    """Return what the search in a folder has found.

    Raises:
        GpsecError: no search has finished there, or its files are damaged.
    """
    try:
        told = json.loads((folder / SETTINGS).read_text("utf-8"))
        table = pd.read_csv(folder / RESULT)
        seed, held_out = int(told["scenario"]["seed"]), int(told["held_out"])
        row = _worst_row(table, JUDGED_BY[told["objective"]])
        settings = {"attack": told["attack"], **told["fixed"], **json.loads(row["parameters"])}
        name = str(told["scenario"]["name"])
    except FileNotFoundError as error:
        missing = Path(error.filename).name
        raise GpsecError(
            f"--worst {shown(folder)}: expected the folder of a finished 'gpsec search', found no {missing}"
        ) from None
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise GpsecError(
            f"--worst {shown(folder)}: expected the files of a search, found others ({shown(error)})"
        ) from None
    others = [seed + number for number in range(1, held_out + 1)]
    plan = plan_config({**settings, "name": WORST}, str(folder / RESULT))
    return FoundWorst(plan, name, (seed, *others, *(AWAY + other for other in others)))


def _worst_row(table: pd.DataFrame, column: str) -> Mapping[str, Any]:
    """Return a row of the plan that is worst on average over what was held out."""
    mean = table.groupby("plan", sort=False)[column].mean()
    if not np.isfinite(mean).any():
        raise ValueError(f"no plan has a figure of {column}")
    found = table[table["plan"] == mean.idxmax()].iloc[0]
    return {str(name): value for name, value in found.items()}

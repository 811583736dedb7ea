"""Takes several runs together, for tables and figures that go into a paper: runs that differ in their seed are one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from gpsec.core.errors import GpsecError
from gpsec.outcomes.naming import base_name, seeded_name
from gpsec.outcomes.ranking import Ranking, rankings
from gpsec.outcomes.reading import bootstrap_of
from gpsec.outcomes.seeds import POOLED, pooled_tables
from gpsec.running.results import Results

_NEEDED = ("detection", "localization", "safety", "events", "vehicles", "curves", "error_bands")


@dataclass(frozen=True)
class Gathered:
    """Runs taken together.

    Attributes:
        tables: by name; those of `POOLED` have a row over all seeds of a scenario.
        seeds: of each scenario, by its name without a seed.
        plans: attack of each plan.
        confidence: of all intervals.
        versions: of gpsec that made them.
    """

    tables: Mapping[str, pd.DataFrame]
    seeds: Mapping[str, tuple[int, ...]]
    plans: Mapping[str, str]
    ranked: Sequence[Ranking]
    confidence: float
    versions: tuple[str, ...]

    def caption(self, scenario: str) -> str:
        """Return what a caption has to say of a scenario: seeds, intervals and the version."""
        drawn = "runs, then of vehicles" if len(self.seeds.get(scenario, ())) > 1 else "vehicles"
        return f"{self.over(scenario)}; {self.confidence:.0%} intervals, bootstrap of {drawn}; {self.made_by}"

    def over(self, scenario: str) -> str:
        """Return which seeds there are of a scenario."""
        seeds = self.seeds.get(scenario, ())
        return f"{len(seeds)} seeds ({', '.join(map(str, seeds))})" if len(seeds) > 1 else f"seed {seeds[0]}"

    @property
    def made_by(self) -> str:
        """The versions of gpsec."""
        return f"gpsec {', '.join(self.versions)}"


def taken_together(runs: Sequence[Results]) -> Gathered:
    """Return runs taken together.

    Raises:
        GpsecError: two of them are the same scenario with the same seed.
    """
    stated = [each for run in runs for each in run.scenarios]
    seeds: dict[str, list[int]] = {}
    for each in stated:
        mine = seeds.setdefault(base_name(each["scenario"]), [])
        if each["seed"] in mine:
            raise GpsecError(f"scenario '{each['scenario']}' with seed {each['seed']} is in two of the runs")
        mine.append(each["seed"])
    parts: dict[str, list[pd.DataFrame]] = {name: [] for name in _NEEDED}
    for run in runs:
        names = {
            each["scenario"]: seeded_name(base_name(each["scenario"]), each["seed"])
            if len(seeds[base_name(each["scenario"])]) > 1
            else each["scenario"]
            for each in run.scenarios
        }
        for name in _NEEDED:
            table = run.tables[name]
            parts[name].append(table.assign(scenario=table["scenario"].astype(str).map(names)))
    tables = {name: _plain(pd.concat(found, ignore_index=True)) for name, found in parts.items()}
    bootstrap = bootstrap_of(stated[0])
    for name, pooled in pooled_tables({key: tables[key] for key in (*POOLED, "events", "vehicles")}, bootstrap).items():
        alone = tables[name][~tables[name]["scenario"].map(base_name).isin(pooled["scenario"])]
        tables[name] = pd.concat([alone, pooled], ignore_index=True)
    plans = {plan["name"]: plan["attack"] for each in stated for plan in each.get("plans", [])}
    versions = tuple(dict.fromkeys(str(each["gpsec_version"]) for each in stated))
    kept = {name: tuple(sorted(found)) for name, found in seeds.items()}
    return Gathered(tables, kept, plans, rankings(tables, bootstrap), bootstrap.confidence, versions)


def _plain(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table whose categories are texts, so that those of several runs can be joined."""
    found = {str(name): table[name].astype(object) for name, kind in table.dtypes.items() if kind == "category"}
    return table.assign(**found)

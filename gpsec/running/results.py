"""Results of a run as pandas frames: ``run = load("results/town")``, then ``run.events`` and so on."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pandas as pd

from gpsec.core.errors import GpsecError, shown
from gpsec.core.geo import Projector
from gpsec.outcomes.columns import read_checked
from gpsec.outcomes.crosscheck import check_together
from gpsec.outcomes.digests import WHOLE, compared
from gpsec.outcomes.geojson import read_features, read_frame
from gpsec.outcomes.manifests import read_manifest, stated_digests
from gpsec.outcomes.naming import base_name
from gpsec.outcomes.ranking import Ranking, rankings
from gpsec.outcomes.reading import bootstrap_of
from gpsec.outcomes.seeds import POOLED
from gpsec.outcomes.stated import check_stated
from gpsec.outcomes.steps import read_steps
from gpsec.outcomes.tables import LARGE_TABLES, MAP, POOLED_PREFIX, STEP_LOG, TABLES, TRACES, whole
from gpsec.outcomes.world_columns import read_worlds
from gpsec.running.workshop import settle
from gpsec.types.constants import MANIFEST

# The longest first, since one ends in another.
_UNITS = {"_per_vehicle_hour": "1/h", "_mps": "m/s", "_rad": "rad", "_deg": "°", "_m": "m", "_s": "s"}
SPREADSHEET = ".spreadsheet.csv"
# What a cell begins with that spreadsheets compute.
_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_WORDS = {"vehicle_hours": "h", "vehicle_seconds": "s", "scored_seconds": "s", "attack_seconds": "s"}
_CATEGORIES = (
    "scenario",
    "vehicle_id",
    "vehicle_type",
    "profile",
    "attack",
    "defence",
    "detector",
    "response",
    "outcome",
    "what",
    "by",
    "edge",
    "lane",
)


def unit(column: str) -> str:
    """Return the unit of a column by its name, such as ``m/s``; empty for counts, shares, flags and names."""
    name = re.sub(r"_(lo|hi)$", "", column)
    if name in _WORDS:
        return _WORDS[name]
    return next((unit for ending, unit in _UNITS.items() if name.endswith(ending)), "")


@dataclass(frozen=True)
class Results:
    """A finished run, as `load` has read and checked it.

    Names are categories, in the order of the run; flags are bool; an empty cell is NaN. `unit` tells the unit of a
    column. Columns are described in ``results/README.md``.

    Attributes:
        folder: of the run.
        scenarios: manifests of the scenarios in it.
        tables: by name; each is an attribute too.
        unfinished: name -> reason of scenarios that were part of the run and are not in the tables.
        worlds: tables of the closed loop by name (``worlds``, ``effects``, ``collisions``, …); none in open loop.
        changed: name -> ``changed``, ``missing`` or ``added`` of tables that are not what the run has written; none
            where it is of a version that kept no digests.

    """

    folder: Path
    scenarios: tuple[dict[str, Any], ...]
    tables: Mapping[str, pd.DataFrame]
    unfinished: dict[str, str] = field(default_factory=dict)
    changed: dict[str, str] = field(default_factory=dict)
    worlds: Mapping[str, pd.DataFrame] = field(default_factory=dict)

    @property
    def detection(self) -> pd.DataFrame:
        """Scenario × sensor profile × attack × detector."""
        return self.tables["detection"]

    @property
    def localization(self) -> pd.DataFrame:
        """Scenario × sensor profile × attack × defence."""
        return self.tables["localization"]

    @property
    def safety(self) -> pd.DataFrame:
        """Scenario × sensor profile × attack × defence."""
        return self.tables["safety"]

    @property
    def association(self) -> pd.DataFrame:
        """Scenario × sensor profile × attack × phase."""
        return self.tables["association"]

    @property
    def events(self) -> pd.DataFrame:
        """Attacked vehicle × attack × defence."""
        return self.tables["events"]

    @property
    def vehicles(self) -> pd.DataFrame:
        """Vehicle × attack × defence."""
        return self.tables["vehicles"]

    @property
    def curves(self) -> pd.DataFrame:
        """Points of ROC and precision-recall."""
        return self.tables["curves"]

    @property
    def error_bands(self) -> pd.DataFrame:
        """Scenario × sensor profile × attack × defence × second of the attack."""
        return self.tables["error_bands"]

    @property
    def places(self) -> pd.DataFrame:
        """Where attacks began, were seen, and vehicles left their lane."""
        return self.tables["places"]

    @property
    def streets(self) -> pd.DataFrame:
        """Edge × attack × defence: exposure, and what happened there."""
        return self.tables["streets"]

    def over_seeds(self) -> "Results | None":
        """Return the results over all seeds of each scenario that was run with several, None where there is none.

        Its detection, localization and safety have a row where those of each run have one, and intervals from a
        bootstrap of runs, then vehicles; its other tables are those of the runs.

        Raises:
            GpsecError: a table is missing, or a cell holds something else than it should.
        """
        if not (self.folder / f"{POOLED_PREFIX}{POOLED[0]}.csv").is_file():
            return None
        tables = {name: _categorised(read_checked(self.folder, f"{POOLED_PREFIX}{name}")) for name in POOLED}
        there = set(tables["safety"]["scenario"])
        firsts = {base_name(stated["scenario"]): stated for stated in reversed(self.scenarios)}
        stated = tuple({**firsts[name], "scenario": name} for name in firsts if name in there)
        return replace(self, scenarios=stated, tables={**self.tables, **tables})

    def rankings(self) -> list[Ranking]:
        """Return the ranking of the defences in each scenario and profile: what terminal and report say of them."""
        return rankings(self.tables, bootstrap_of(self.scenarios[0]))

    def manifest(self, scenario: str) -> dict[str, Any]:
        """Return the manifest of one scenario.

        Raises:
            GpsecError: the run has none of that name.
        """
        for stated in self.scenarios:
            if stated["scenario"] == scenario:
                return stated
        names = ", ".join(stated["scenario"] for stated in self.scenarios)
        raise GpsecError(f"{self.folder}: no scenario '{shown(scenario)}' in this run (there are: {shown(names)})")

    def file_of(self, scenario: str, name: str) -> Path:
        """Return where a scenario has its `STEP_LOG`, `TRACES` or `MAP`; the file need not be there."""
        file = Path(name)
        alone = len(self.scenarios) == 1
        return self.folder / (name if alone else f"{file.stem}-{scenario}{file.suffix}")

    def steps(self, scenario: str, vehicles: list[str] | None = None) -> pd.DataFrame | None:
        """Return the logged steps of a scenario, of all or some of its vehicles; None where they were not logged.

        Raises:
            GpsecError: the file is not the one that the run has written.
        """
        return self._rows_of(self.file_of(scenario, STEP_LOG), vehicles)

    def traces(self, scenario: str, vehicles: list[str] | None = None) -> pd.DataFrame | None:
        """Return the traces that the run has kept, of all or some of its vehicles, in the columns of the step log.

        None where there are none: the steps of all were logged, or nobody has any in closed loop.

        Raises:
            GpsecError: the file is not the one that the run has written.
        """
        return self._rows_of(self.file_of(scenario, TRACES), vehicles)

    def _rows_of(self, path: Path, vehicles: list[str] | None) -> pd.DataFrame | None:
        if not path.is_file():
            return None
        if path.name in self.changed:
            raise GpsecError(f"{path}: expected the steps that the run has written, found another file")
        return read_steps(path, vehicles)

    def map(self, scenario: str) -> list[dict[str, Any]]:
        """Return the GeoJSON features of a scenario's map: lanes and zones; none where the run has no map.

        Raises:
            GpsecError: the file is no such map.
        """
        return read_features(self.file_of(scenario, MAP))

    def frame(self, scenario: str) -> Projector | None:
        """Return the frame of a scenario's net; None where its map does not say."""
        return read_frame(self.file_of(scenario, MAP))


def write_parquet(run: Results) -> None:
    """Write the large tables as Parquet files beside their CSV files, with the types that `Results` gives them."""
    for name in LARGE_TABLES:
        with whole(run.folder / f"{name}.parquet") as partial:
            getattr(run, name).to_parquet(partial, index=False)


def write_spreadsheets(run: Results) -> list[Path]:
    """Write the tables once more for a spreadsheet, as ``events.spreadsheet.csv`` and so on; return where they are.

    A text that a spreadsheet would take for a formula, such as the id ``=1+1``, begins with an apostrophe there.
    """
    paths = []
    for name in TABLES:
        table = pd.read_csv(run.folder / f"{name}.csv", dtype=str, keep_default_na=False)
        paths.append(run.folder / f"{name}{SPREADSHEET}")
        with whole(paths[-1]) as partial:
            # The mark in front lets spreadsheets know that it is UTF-8.
            table.map(_as_text).to_csv(partial, index=False, lineterminator="\n", encoding="utf-8-sig")
    return paths


def _as_text(cell: str) -> str:
    return f"'{cell}" if cell.startswith(_FORMULA) and not _NUMBER.fullmatch(cell) else cell


def _categorised(table: pd.DataFrame) -> pd.DataFrame:
    for column in table.columns.intersection(pd.Index(_CATEGORIES)):
        table[column] = pd.Categorical(table[column], table[column].dropna().unique())
    return table


def load(folder: Path | str) -> Results:
    """Return the results in a folder that `gpsec run` has written, wherever it has been moved.

    Anybody may have edited or damaged them: manifest, tables and maps are checked here, once. Where a run was killed
    while it took the place of another one there, that is brought to its end first.

    Raises:
        GpsecError: it is no such folder, something in it is not what it should be, or a run is taking its place there.

    """
    place = Path(folder)
    if not place.is_dir():
        raise GpsecError(f"{place}: expected the folder of a run, found {'a file' if place.exists() else 'nothing'}")
    settle(place)
    stated = read_manifest(place)
    if stated is None:
        raise GpsecError(f"{place}: expected the folder of a run, found no {MANIFEST} in it")
    check_stated(place, stated)
    tables = {name: read_checked(place, name) for name in TABLES}
    worlds = read_worlds(place)
    check_together(place, [each["scenario"] for each in stated["scenarios"]], tables, forks=not worlds)
    for table in tables.values():
        _categorised(table)
    run = Results(
        place,
        tuple(stated["scenarios"]),
        tables,
        {entry["scenario"]: entry["reason"] for entry in stated.get("unfinished", [])},
        _changed(place, stated_digests(place, stated)),
        worlds,
    )
    for each in run.scenarios:
        run.map(each["scenario"])
    return run


def _changed(folder: Path, stated: Mapping[str, str] | None) -> dict[str, str]:
    """Return the tables that are not what was written; none where nobody knows what was."""
    if stated is None:
        return {}
    return {name: state for name, state in compared(folder, stated).items() if state != WHOLE}

"""Whether the tables of a run belong together, each of which anybody may have edited."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from gpsec.core.errors import GpsecError, nearest, shown

_GROUP = ["scenario", "profile"]
_VEHICLE = ["scenario", "vehicle_id"]


def check_together(folder: Path, scenarios: Sequence[str], tables: Mapping[str, pd.DataFrame]) -> None:
    """Refuse tables that speak of something that is missing where a report would look for it.

    Raises:
        GpsecError: naming the table, and what is missing.
    """
    groups = set(tables["detection"][_GROUP].itertuples(index=False, name=None))
    defences = set(tables["safety"]["defence"])
    for name, table in tables.items():
        path = folder / f"{name}.csv"
        for scenario in table["scenario"].unique():
            if scenario not in scenarios:
                known = nearest(scenario, scenarios)
                raise GpsecError(f"{path}: scenario '{shown(scenario)}' is not in the manifest: {known}")
        for scenario, profile in table[_GROUP].drop_duplicates().itertuples(index=False, name=None):
            if (scenario, profile) not in groups:
                raise GpsecError(
                    f"{path}: expected scenarios and profiles of detection.csv, found '{shown(scenario)}' with"
                    f" '{shown(profile)}'"
                )
        for defence in table["defence"].unique() if "defence" in table else ():
            if defence not in defences:
                known = nearest(defence, defences)
                raise GpsecError(f"{path}: defence '{shown(defence)}' is not in safety.csv: {known}")
    _check_safety(folder / "safety.csv", tables["safety"])
    benign = tables["vehicles"][tables["vehicles"]["attack"] == "none"]
    there = set(benign[_VEHICLE].itertuples(index=False, name=None))
    for name in ("vehicles", "events"):
        for scenario, vehicle in tables[name][_VEHICLE].drop_duplicates().itertuples(index=False, name=None):
            if (scenario, vehicle) not in there:
                raise GpsecError(
                    f"{folder / name}.csv: vehicle '{shown(vehicle)}' of '{shown(scenario)}': expected a row without an"
                    " attack in vehicles.csv, found none"
                )


def _check_safety(path: Path, safety: pd.DataFrame) -> None:
    """Refuse a table in which not every attack was met by every defence, all with the same vehicles."""
    for (scenario, profile), rows in safety.groupby(_GROUP, sort=False):
        defences = set(rows["defence"])
        for attack, those in rows.groupby("attack", sort=False):
            if len(those) != len(defences) or set(those["defence"]) != defences or len(set(those["n_vehicles"])) > 1:
                raise GpsecError(
                    f"{path}: '{shown(scenario)}' with '{shown(profile)}' under '{shown(attack)}': expected one row for"
                    f" each of {len(defences)} defences, all with the same vehicles, found others"
                )

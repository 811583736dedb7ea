"""Whether the tables of a run belong together, each of which anybody may have edited."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from gpsec.core.errors import GpsecError, nearest, shown

_GROUP = ["scenario", "profile"]
_VEHICLE = ["scenario", "vehicle_id"]


def check_together(
    folder: Path, scenarios: Sequence[str], tables: Mapping[str, pd.DataFrame], *, forks: bool = True
) -> None:
    """Refuse tables that speak of something that is missing where a report would look for it.

    Where attacks do not fork (`forks`), in closed loop, attacked vehicles have no row without the attack.

    Raises:
        GpsecError: naming the table, and what is missing.
    """
    groups = set(tables["detection"][_GROUP].itertuples(index=False, name=None))
    defences = set(tables["safety"]["defence"])
    for name, table in tables.items():
        path = folder / f"{name}.csv"
        for scenario in table["scenario"].unique():
            if scenario not in scenarios:
                hint = nearest(scenario, scenarios)
                raise GpsecError(f"{path}: scenario '{shown(scenario)}' is not in the manifest: {hint}")
        for scenario, profile in table[_GROUP].drop_duplicates().itertuples(index=False, name=None):
            if (scenario, profile) not in groups:
                raise GpsecError(
                    f"{path}: expected scenarios and profiles of detection.csv, found '{shown(scenario)}' with"
                    f" '{shown(profile)}'"
                )
        for defence in table["defence"].unique() if "defence" in table else ():
            if defence not in defences:
                hint = nearest(defence, defences)
                raise GpsecError(f"{path}: defence '{shown(defence)}' is not in safety.csv: {hint}")
    _check_safety(folder / "safety.csv", tables["safety"])
    vehicles = tables["vehicles"]
    known = vehicles[vehicles["attack"] == "none"] if forks else vehicles
    there = set(known[_VEHICLE].itertuples(index=False, name=None))
    for name in ("vehicles", "events"):
        for scenario, vehicle in tables[name][_VEHICLE].drop_duplicates().itertuples(index=False, name=None):
            if (scenario, vehicle) not in there:
                raise GpsecError(
                    f"{folder / name}.csv: vehicle '{shown(vehicle)}' of '{shown(scenario)}': expected a row"
                    f"{' without an attack' if forks else ''} in vehicles.csv, found none"
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

"""What became of the honest and of the attacked vehicles of some runs, for each defence."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from gpsec.outcomes.tables import read_table
from gpsec.paper import pool
from gpsec.paper.pool import Estimate

_HONEST = "none"


def stress_rows(folders: Sequence[Path]) -> pd.DataFrame:
    """Return a row for each defence and attack of runs of one world; see results/README.md for the columns.

    Where nobody was attacked there is a row for each defence, with the attack `none`.
    """
    vehicles, events = (
        pd.concat([read_table(folder, name).assign(run=folder.name) for folder in folders], ignore_index=True)
        for name in ("vehicles", "events")
    )
    honest = vehicles[(vehicles["attack"] == _HONEST) & (vehicles["vehicle_seconds"] > 0.0)]
    rows = []
    for defence in honest["defence"].unique():
        mine = honest[honest["defence"] == defence]
        detector, response = str(mine["detector"].iloc[0]), str(mine["response"].iloc[0])
        common = {"detector": detector, "response": response, **_of_honest(mine, detector)}
        attacks = events["attack"].unique()
        for attack in attacks:
            found = pool.detection(pool.of_defence(events, defence, attack))
            rows.append({**common, "attack": attack, "n_events": found["f1"].n, **_of_attacked(found)})
        if not len(attacks):
            rows.append({**common, "attack": _HONEST, "n_events": 0})
    table = pd.DataFrame(rows)
    return table[[*(name for name in STRESS_COLUMNS if name in table.columns)]].reindex(columns=list(STRESS_COLUMNS))


def _of_honest(vehicles: pd.DataFrame, detector: str) -> dict[str, object]:
    known = vehicles["outcome"].notna()
    return {
        "n_vehicles": len(vehicles),
        "vehicle_hours": vehicles["vehicle_seconds"].sum() / 3600.0,
        **_spread("false_alarms_per_vehicle_hour", pool.false_alarms(vehicles, detector)),
        "line_touched": int((vehicles["outcome"] != _HONEST)[known].sum()) if known.any() else None,
    }


def _of_attacked(found: dict[str, Estimate]) -> dict[str, object]:
    spread: dict[str, object] = {}
    for name in ("detected_share", "delay_mean_s", "f1"):
        spread |= _spread(name, found[name])
    return spread


def _spread(name: str, found: Estimate) -> dict[str, object]:
    return {name: found.value, f"{name}_lo": found.low, f"{name}_hi": found.high}


STRESS_COLUMNS = (
    "detector",
    "response",
    "attack",
    "n_vehicles",
    "vehicle_hours",
    *(f"false_alarms_per_vehicle_hour{end}" for end in ("", "_lo", "_hi")),
    "line_touched",
    "n_events",
    *(f"{name}{end}" for name in ("detected_share", "delay_mean_s", "f1") for end in ("", "_lo", "_hi")),
)

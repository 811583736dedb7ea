"""A run in closed loop made by hand: two seeds of a benign, an undefended and a defended world; no SUMO."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from gpsec.outcomes.effects import effects_table
from gpsec.outcomes.tables import write_frame
from gpsec.outcomes.true_outcomes import WorldTotals
from gpsec.outcomes.worlds import WorldEnd, WorldKey, write_kept, write_world

from .conftest import EVIL, NET, write_run

# Collisions in 100 km and delay of the worlds of both seeds.
FOUND = {("none", "never+none"): ((0, 1.0), (0, 3.0)), (EVIL, "never+none"): ((4, 5.0), (8, 9.0))}
FOUND[EVIL, "cusum+ukf"] = ((0, 1.0), (1, 3.0))
NAME = "lane"


def write_worlds_run(folder: Path) -> Path:
    """Write the run; its base tables are those of `write_run`."""
    write_run(folder, f"{NAME}-world-01-seed-1", log=False)
    parts: dict[str, list[pd.DataFrame]] = {}
    for number, ((plan, defence), seeds) in enumerate(FOUND.items()):
        for seed, (collisions, delay_s) in enumerate(seeds, 1):
            key = WorldKey(f"{NAME}-world-{number:02d}-seed-{seed}", seed, plan, defence, "continue")
            for name, table in _world(folder / "one", key, collisions, delay_s).items():
                parts.setdefault(name, []).append(table)
    for name, tables in parts.items():
        whole = pd.concat([table for table in tables if len(table)] or tables[:1])
        write_frame(whole, folder / f"{name}.csv")
    write_frame(effects_table(pd.concat(parts["worlds"])), folder / "effects.csv")
    manifest = json.loads((folder / "manifest.json").read_text("utf-8"))
    manifest["scenarios"][0]["closed_loop"] = {
        "net": {"projection": NET.definition, "offset_m": list(NET.offset_m)},
    }
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return folder


def _world(folder: Path, key: WorldKey, collisions: int, delay_s: float) -> Mapping[str, pd.DataFrame]:
    folder.mkdir(exist_ok=True)
    events = pd.DataFrame({"vehicle_id": ["v"], "defence": [key.defence], "outcome": ["none"]})
    write_frame(events, folder / "events.csv")
    totals = WorldTotals(vehicles=20, attacked=5, vehicle_km=100.0, arrived=7, steps=1000, standing_steps=50)
    hits = [_hit(number) for number in range(collisions)]
    write_world(folder, key, WorldEnd(totals, hits, [], delay_s, 0, 0, 0, 0, 0, 0.0), 0.1)
    kept = {"crashes": _crash() if collisions else [], "standing": _stood(key), "jams": _jam(collisions)}
    write_kept(folder, key, kept)
    names = ("worlds", "collisions", "crashes", "standing", "jams")
    return {name: pd.read_csv(folder / f"{name}.csv", keep_default_na=False, na_values=[""]) for name in names}


def _hit(number: int) -> dict[str, Any]:
    place = {"time_s": 9.0, "x_m": 50.0 + number, "y_m": 1.0, "longitude": 9.0, "latitude": 52.0, "vehicle_id": EVIL}
    who = {"other_id": "b", "kind": ("oncoming", "same")[number % 2], "closing_mps": 12.0, "attacked": True}
    return {**place, **who, "other_attacked": False, "displacement_m": 2.0, "slow": False}


def _crash() -> list[dict[str, Any]]:
    rows = []
    for vehicle, way in ((EVIL, 1.0), ("b", -1.0)):
        for step in range(51):
            time_s = 9.0 - 0.2 * (50 - step)
            x_m = 50.0 + way * (10.0 * (time_s - 9.0) - 2.0)
            known = {"estimate_x_m": x_m, "estimate_y_m": -1.5} if way > 0.0 else {}
            body = {"yaw_rad": 0.0 if way > 0.0 else 3.1416, "speed_mps": 10.0, "length_m": 4.5, "width_m": 1.8}
            told = {"kind": "oncoming", "closing_mps": 20.0, "crash_s": 9.0, "vehicle_id": vehicle, "time_s": time_s}
            place = {"x_m": x_m, "y_m": 0.0, "displacement_m": 1.5 if way > 0.0 else 0.0}
            rows.append({**told, **place, **body, **known, "attacked": way > 0.0, "alarm": False})
    return [{**row, **{name: row.get(name) for name in ("estimate_x_m", "estimate_y_m")}} for row in rows]


def _stood(key: WorldKey) -> list[dict[str, Any]]:
    return [{"road": "-3", "standing_s": 10.0 if key.plan == "none" else 30.0 + 5.0 * key.seed}]


def _jam(collisions: int) -> list[dict[str, Any]]:
    if not collisions:
        return []
    rows = []
    for time in range(10):
        wreck = {"vehicle": 0, "position_m": 80.0, "speed_mps": 0.0, "stopped": True, "attacked": False}
        other = {"vehicle": 1, "position_m": 8.0 * time, "speed_mps": 8.0, "stopped": False, "attacked": True}
        for one in (wreck, other):
            rows.append({"road": "-3", "length_m": 100.0, "time_s": float(time), **one})
    return rows

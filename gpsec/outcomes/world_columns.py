"""What is in the tables of the closed loop, which anybody may have edited; ``results/README.md`` says what it means."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pandas as pd

from gpsec.core.errors import GpsecError
from gpsec.outcomes.columns import as_flags, as_numbers, as_texts, read_rows
from gpsec.outcomes.effects import MEASURES, WORLD_KEY
from gpsec.outcomes.tables import EFFECTS, WORLD_TABLES
from gpsec.outcomes.worlds import COLLISION_COLUMNS, COLLISION_KINDS, KEPT_COLUMNS

_TEXTS = {"scenario", "plan", "defence", "on_alarm", "vehicle_id", "other_id", "kind", "road"}
_FLAGS = {"other_attacked", "alarm", "stopped"}
# Of a world these are counts, of a collision or a moment a flag.
_FLAG_BUT_OF_WORLDS = "attacked"
_COUNTS = {"seed", "vehicles", "arrived", "out_of_lane", "collisions", "seeds", "vehicle"}
# There is none with one seed, and of who is no part of the fleet.
_MAY_BE_EMPTY = {"estimate_x_m", "estimate_y_m"}
_WORLD = ("scenario", "seed", *WORLD_KEY[1:])
_SEEN = {
    "worlds": (
        *(*_WORLD, "vehicles", "attacked", "vehicle_km", "arrived", "mean_speed_mps", "delay_s", "standing_share"),
        *("out_of_lane", "collisions"),
    ),
    "collisions": (*_WORLD, *COLLISION_COLUMNS),
    **{name: (*_WORLD, *columns) for name, columns in KEPT_COLUMNS.items()},
    EFFECTS: (*WORLD_KEY, "seeds", *MEASURES, *(f"{name}_{end}" for name in MEASURES for end in ("low", "high"))),
}


def read_worlds(folder: Path) -> dict[str, pd.DataFrame]:
    """Return the tables of a run in closed loop by their names, none where it was not one.

    Raises:
        GpsecError: one is missing or no such table, or a cell holds something else than it should.
    """
    if not (folder / "worlds.csv").is_file():
        return {}
    return {name: _read(folder, name, _SEEN[name]) for name in (*WORLD_TABLES, EFFECTS)}


def _read(folder: Path, name: str, columns: Iterable[str]) -> pd.DataFrame:
    path, frame = folder / f"{name}.csv", read_rows(folder, name)
    for column in columns:
        if column not in frame:
            raise GpsecError(f"{path}: expected a table of a run in closed loop, found no column '{column}'")
        frame[column] = _checked(path, column, frame[column], of_worlds=name == "worlds", of_effects=name == EFFECTS)
    return frame


def _checked(
    path: Path, column: str, values: "pd.Series[Any]", *, of_worlds: bool, of_effects: bool
) -> "pd.Series[Any]":
    if column in _TEXTS:
        return as_texts(path, column, values, COLLISION_KINDS if column == "kind" else None)
    if column in _FLAGS or (column == _FLAG_BUT_OF_WORLDS and not of_worlds):
        return as_flags(path, column, values)
    whole = (column in _COUNTS or column == _FLAG_BUT_OF_WORLDS) and (not of_effects or column == "seeds")
    optional = column in _MAY_BE_EMPTY or (of_effects and column not in {*WORLD_KEY, "seeds"})
    return as_numbers(path, column, values, required=not optional, whole=whole)

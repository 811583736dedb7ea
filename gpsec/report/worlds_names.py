"""What worlds are called on a page: the attack that a reader chooses, and the defence and reaction beside it."""

from collections.abc import Iterable, Mapping
from typing import Any

import pandas as pd

from gpsec.outcomes.effects import BENIGN_PLAN, WORLD_KEY
from gpsec.outcomes.naming import scenario_of_world

INJECTED = "false alarms"


def attack_name(row: Mapping[Any, Any]) -> str:
    """Return what a page calls the attack of a world: its plan, false alarms that were injected, or `none`."""
    plan = str(row["plan"])
    if row["false_alarms_per_h"] == 0.0:
        return plan
    return INJECTED if plan == BENIGN_PLAN else f"{plan} and {INJECTED}"


def world_label(row: Mapping[Any, Any]) -> str:
    """Return the defence and the reaction of a world, and the rate of false alarms where some were injected."""
    rate = f", {row['false_alarms_per_h']:g} an hour" if row["false_alarms_per_h"] > 0.0 else ""
    return f"{row['defence']}, {row['on_alarm']}{rate}"


def by_world(table: pd.DataFrame) -> Iterable[tuple[dict[str, Any], pd.DataFrame]]:
    """Yield (the world, its rows in all seeds) in the order of the table; scenarios go by their own names."""
    named = table.assign(scenario=[scenario_of_world(str(name)) for name in table["scenario"]], run=table["scenario"])
    for values, rows in named.groupby(WORLD_KEY, sort=False):
        yield dict(zip(WORLD_KEY, values, strict=True)), rows


def where(world: Mapping[Any, Any]) -> dict[str, str]:
    """Return under which choices of a page a series of a world is shown."""
    return {"group": str(world["scenario"]), "attack": attack_name(world)}

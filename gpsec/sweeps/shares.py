"""The rows of a smaller share: filtered from those of the largest, which was simulated.

A vehicle is part of the fleet, or attacked under a plan, where its draw is below the share. The draw depends on seed
and vehicle alone, so that what a vehicle does is the same in both.
"""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from gpsec.core import noise
from gpsec.outcomes.seeds import reaches
from gpsec.outcomes.state import OUTCOMES
from gpsec.traffic.names import first_life

SHARE_DRAW, EQUIPPED_DRAW = "share_draw", "equipped_draw"
_Tables = Mapping[str, pd.DataFrame]


def with_draws(table: pd.DataFrame, seed: int) -> pd.DataFrame:
    """Return a table of vehicles with the draws that say which shares they are part of."""
    names = table["vehicle_id"].unique()
    plan = {name: noise.plain_uniform(noise.vehicle_key(seed, name), noise.PLAN_SHARE, 0) for name in names}
    fleet = {
        name: noise.plain_uniform(noise.vehicle_key(seed, first_life(name)), noise.FLEET_EQUIPPED, 0) for name in names
    }
    return table.assign(**{SHARE_DRAW: table["vehicle_id"].map(plan), EQUIPPED_DRAW: table["vehicle_id"].map(fleet)})


def filtered(tables: _Tables, attack: str, share: float | None, equipped: float | None) -> dict[str, pd.DataFrame]:
    """Return what runs with smaller shares would have of one attack and of the vehicles without one.

    Counts of outcomes are those of the vehicles that stay, honest ones each by the worst that it came to. What events
    and vehicles do not tell stays as it is.

    Args:
        tables: of `POOLED`, and `events` and `vehicles` with draws.
        attack: name of the plan.
        share: of the vehicles that it attacks, None for all that it did.
        equipped: share of the fleet, None for all of it.
    """
    found = of_attack(tables, attack)
    for name in ("events", "vehicles"):
        table = found[name]
        kept = pd.Series(True, table.index)
        if share is not None:
            kept &= (table[SHARE_DRAW] < share) | (table["attack"] == "none")
        if equipped is not None:
            kept &= table[EQUIPPED_DRAW] < equipped
        found[name] = table[kept]
    return found | {"safety": _recounted(found)}


def of_attack(tables: _Tables, attack: str) -> dict[str, pd.DataFrame]:
    """Return the tables of one attack, `vehicles` with those without one, to which it is compared."""
    return {
        name: table[table["attack"].isin([attack, "none"] if name == "vehicles" else [attack])]
        for name, table in tables.items()
    }


def _recounted(tables: _Tables) -> pd.DataFrame:
    """Return the safety table with the outcomes of the vehicles that are there."""
    safety = tables["safety"].copy()
    key = ["scenario", "profile", "attack", "defence"]
    honest = tables["vehicles"][tables["vehicles"]["attack"] == "none"]
    came_to = {f"reached_{outcome}": reaches(honest["outcome"], place) for place, outcome in enumerate(OUTCOMES)}
    rows = pd.concat([tables["events"][[*key, *came_to]], honest[key].assign(**came_to)])
    counts = rows.groupby(key)[list(came_to)].sum().reindex(pd.MultiIndex.from_frame(safety[key]), fill_value=0)
    for outcome in OUTCOMES:
        safety[outcome] = np.where(safety[outcome].isna(), np.nan, counts[f"reached_{outcome}"].astype(float))
    return safety

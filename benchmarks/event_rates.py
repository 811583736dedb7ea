"""How often things happen in worlds, against their twins: ``python -m benchmarks.event_rates FOLDER``.

Rates are sums of events over sums of exposure: 1,000 vehicle-kilometres, and vehicle-hours. Seeds are the clusters:
what happens in one world hangs together, since a crash makes a jam and a jam makes crashes. So whole seeds are drawn,
each with its world and its twin.
"""

import argparse
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from rich.console import Console
from rich.table import Table

from gpsec.core.arrays import Floats
from gpsec.core.errors import GpsecError
from gpsec.outcomes.effects import WORLD_KEY, with_collision_rates, with_twins
from gpsec.outcomes.tables import read_table

KINDS = (
    *("collisions", "collisions_oncoming", "collisions_with_others", "collisions_with_wrecks", "out_of_lane"),
    *("ttc_under_1_5_s", "drac_over_3_4_mps2", "hard_brakings", "alarms", "stops", "stuck"),
)
_REPLICATES, _SEED = 4000, 2026


def event_rates(worlds: pd.DataFrame, confidence: float = 0.95) -> pd.DataFrame:
    """Return a row for each kind of event in worlds of one plan, defence and reaction.

    `events` and `twin_events` are counts over the seeds that have both; `per_1000_vkm` and `per_vehicle_hour` are the
    world's rate less the twin's, with `_low` and `_high` where there are two seeds or more.
    """
    named = with_collision_rates(worlds)
    return pd.DataFrame([row for group in with_twins(named) for row in _rows(*group, confidence)])


def _rows(
    names: dict[str, Any], group: pd.DataFrame, twins: pd.DataFrame, confidence: float
) -> Iterator[dict[str, Any]]:
    paired = twins["vehicle_km"].notna().to_numpy()
    pair = [table[paired].reset_index(drop=True) for table in (group, twins)]
    drawn = np.random.default_rng(_SEED).integers(0, max(paired.sum(), 1), (_REPLICATES, paired.sum()))
    for kind in KINDS:
        row = names | {"kind": kind, "seeds": int(paired.sum())}
        row |= {"events": int(pair[0][kind].sum()), "twin_events": int(pair[1][kind].sum())}
        for rate, exposures in (("per_1000_vkm", _thousand_km), ("per_vehicle_hour", _hours)):
            sums = [(table[kind].to_numpy(np.float64), exposures(table)) for table in pair]
            row[rate] = float(_difference(sums, np.arange(paired.sum())[np.newaxis])[0]) if paired.any() else np.nan
            row[f"{rate}_low"] = row[f"{rate}_high"] = np.nan
            if paired.sum() > 1:
                tail = 50.0 * (1.0 - confidence)
                row[f"{rate}_low"], row[f"{rate}_high"] = np.percentile(_difference(sums, drawn), [tail, 100.0 - tail])
        yield row


def _difference(sums: list[tuple[Floats, Floats]], drawn: np.ndarray) -> Floats:
    """Return (B,) rates of the worlds less those of the twins, of (B, S) seeds that are drawn."""
    world, twin = (events[drawn].sum(axis=1) / exposure[drawn].sum(axis=1) for events, exposure in sums)
    return np.asarray(world - twin)


def _thousand_km(table: pd.DataFrame) -> Floats:
    return table["vehicle_km"].to_numpy(np.float64) / 1000.0


def _hours(table: pd.DataFrame) -> Floats:
    return table["vehicle_km"].to_numpy(np.float64) / (3.6 * table["mean_speed_mps"].to_numpy(np.float64))


def main(arguments: list[str] | None = None) -> int:
    """Print the rates of a run; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.event_rates", description=__doc__)
    parser.add_argument("folder", type=Path, help="of a run in closed loop")
    try:
        found = event_rates(read_table(parser.parse_args(arguments).folder, "worlds"))
    except GpsecError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.status
    console = Console()
    for key, rows in found.groupby(WORLD_KEY, sort=False):
        table = Table("event", "worlds", "twins", "per 1,000 vehicle-km", "per vehicle-hour")
        for row in rows[(rows["events"] > 0) | (rows["twin_events"] > 0)].to_dict("records"):
            table.add_row(
                row["kind"],
                str(row["events"]),
                str(row["twin_events"]),
                _said(row, "per_1000_vkm"),
                _said(row, "per_vehicle_hour"),
            )
        console.print(" ".join(str(name) for name in key), f"{rows['seeds'].iloc[0]} seeds", highlight=False)
        console.print(table)
    return 0


def _said(row: Mapping[Any, Any], name: str) -> str:
    low, high = row[f"{name}_low"], row[f"{name}_high"]
    return f"{row[name]:+.3g}" if np.isnan(low) else f"{row[name]:+.3g} ({low:.3g}, {high:.3g})"


if __name__ == "__main__":
    sys.exit(main())

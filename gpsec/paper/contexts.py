"""Where on the road an attack is seen: in junctions, where the camera sees nothing, and beside lane changes."""

from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pyarrow import parquet

from gpsec.outcomes.tables import STEP_LOG
from gpsec.paper import pool
from gpsec.paper.pool import Estimate

# A lane change is a change to another lane of the same edge; this much time on both sides of it counts.
BESIDE_S = 2.0
JUNCTION, LANE_CHANGE, ROAD = "junction", "lane change", "road"


def recall_by_context(run: Path, attack: str) -> dict[str, dict[str, Estimate]]:
    """Return detector -> context -> share of the attacked steps that are in alarm, scored or not.

    A step belongs to the junction where its lane is inside one, else to a lane change within `BESIDE_S`, else to the
    road. Unlike in the tables, steps without a score count here: they are what a vehicle goes through.
    """
    log = pool.named_plainly(parquet.read_table(run / STEP_LOG).to_pandas())
    log = log[log["plan"] == attack].sort_values(["vehicle_id", "time_s"], ignore_index=True)
    log["context"] = _context(log)
    log = log[log["attacked"]]
    found = {}
    for column in log.columns:
        name = column.removesuffix("_alarm")
        if name == column or name in ("never", "told"):
            continue
        found[name] = {
            context: _share(log[log["context"] == context], column) for context in (ROAD, LANE_CHANGE, JUNCTION)
        }
    return found


def _context(log: pd.DataFrame) -> NDArray[np.str_]:
    edge = log["lane"].str.rpartition("_")[0]
    same = log["vehicle_id"].eq(log["vehicle_id"].shift()) & edge.eq(edge.shift())
    changed = same & log["lane"].ne(log["lane"].shift())
    change_s = log["time_s"].where(changed)
    last = change_s.groupby(log["vehicle_id"]).ffill()
    following = change_s.groupby(log["vehicle_id"]).bfill()
    beside = ((log["time_s"] - last) <= BESIDE_S) | ((following - log["time_s"]) <= BESIDE_S)
    return np.where(log["lane"].str.startswith(":"), JUNCTION, np.where(beside, LANE_CHANGE, ROAD))


def _share(log: pd.DataFrame, column: str) -> Estimate:
    """Return the share of steps in alarm, with an interval over vehicles."""
    of_vehicle = log.groupby("vehicle_id")[column].agg(["sum", "count"])
    return pool.rate(of_vehicle["sum"], of_vehicle["count"])

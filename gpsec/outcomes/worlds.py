"""The tables of the closed loop: `worlds.csv`, `collisions.csv`, and what it adds to `events.csv`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from gpsec.outcomes.state import OFF_ROAD, OUT_OF_LANE, WRONG_WAY
from gpsec.outcomes.tables import read_table, whole, write_frame
from gpsec.outcomes.true_outcomes import WorldTotals

COLLISION_COLUMNS = (
    *("time_s", "x_m", "y_m", "longitude", "latitude", "vehicle_id", "other_id", "kind", "closing_mps"),
    *("attacked", "other_attacked", "displacement_m"),
)
# Of what is kept for the report, beside the columns of the world.
KEPT_COLUMNS = {
    "crashes": (
        *("kind", "closing_mps", "crash_s", "vehicle_id", "time_s", "x_m", "y_m", "yaw_rad", "speed_mps", "length_m"),
        *("width_m", "displacement_m", "estimate_x_m", "estimate_y_m", "attacked", "alarm"),
    ),
    "standing": ("road", "standing_s"),
    "jams": ("road", "length_m", "time_s", "vehicle", "position_m", "speed_mps", "stopped", "attacked"),
}
STORY_COLUMNS = (
    *("displaced_max_m", "true_outcome", "true_outcome_s", "open_loop_outcome"),
    *("crash_s", "crash_kind", "stood_s", "released_s"),
)
WRECK, ONCOMING = "wreck", "oncoming"
COLLISION_KINDS = (ONCOMING, "crossing", "same", WRECK)


@dataclass(frozen=True)
class WorldKey:
    """What tells a world from others, the first columns of its rows."""

    scenario: str
    seed: int
    plan: str
    defence: str
    on_alarm: str
    false_alarms_per_h: float = 0.0


@dataclass(frozen=True)
class WorldEnd:
    """What is known at the end of a world.

    Attributes:
        totals: of the fleet.
        collisions: a row each, with `COLLISION_COLUMNS` and `slow` (not hard enough to stop anybody).
        stories: of the attacked vehicles.
        delay_s: mean time that a vehicle of the fleet lost against free driving.
        ttc, drac: critical moments; see `gpsec.encounters`.
        mrm: minimal-risk manoeuvres.
        stuck, removed: vehicles that stood for no reason, and wrecks that were taken away.
        surplus_share: share of the steered vehicle-steps in which SUMO did not have a vehicle where it truly was.
    """

    totals: WorldTotals
    collisions: Sequence[Mapping[str, Any]]
    stories: Sequence[Mapping[str, Any]]
    delay_s: float
    ttc: int
    drac: int
    mrm: int
    stuck: int
    removed: int
    surplus_share: float


def write_world(folder: Path, key: WorldKey, end: WorldEnd, step_s: float) -> None:
    """Write the tables of a world, and add the columns of its stories to its `events.csv`, which is there."""
    with whole(folder / "worlds.csv") as partial:
        write_frame(pd.DataFrame([vars(key) | _figures(end, step_s)]), partial)
    rows = [vars(key) | {name: hit[name] for name in COLLISION_COLUMNS} for hit in end.collisions if not hit["slow"]]
    with whole(folder / "collisions.csv") as partial:
        write_frame(pd.DataFrame(rows, columns=[*vars(key), *COLLISION_COLUMNS]), partial)
    events = _with_stories(read_table(folder, "events"), end.stories, key.defence)
    with whole(folder / "events.csv") as partial:
        write_frame(events, partial)


def write_kept(folder: Path, key: WorldKey, tables: Mapping[str, Sequence[Mapping[str, Any]]]) -> None:
    """Write the tables of what is kept of a world, by their names in `KEPT_COLUMNS`."""
    for name, columns in KEPT_COLUMNS.items():
        rows = [vars(key) | dict(row) for row in tables[name]]
        with whole(folder / f"{name}.csv") as partial:
            write_frame(pd.DataFrame(rows, columns=[*vars(key), *columns]), partial)


def _figures(end: WorldEnd, step_s: float) -> dict[str, Any]:
    totals, hard = end.totals, [hit for hit in end.collisions if not hit["slow"]]
    first = [hit for hit in hard if hit["kind"] != WRECK]
    steps = max(totals.steps, 1)
    return {
        "vehicles": totals.vehicles,
        "attacked": totals.attacked,
        "vehicle_km": totals.vehicle_km,
        "arrived": totals.arrived,
        "mean_speed_mps": totals.vehicle_km * 1000.0 / (steps * step_s),
        "delay_s": end.delay_s,
        "standing_share": totals.standing_steps / steps,
        "out_of_lane": int(totals.reached[OUT_OF_LANE]),
        "wrong_way": int(totals.reached[WRONG_WAY]),
        "wrong_way_s": totals.wrong_way_steps * step_s,
        "off_road": int(totals.reached[OFF_ROAD]),
        "collisions": len(first),
        "collisions_oncoming": sum(hit["kind"] == ONCOMING for hit in first),
        "collisions_with_others": sum(not (hit["attacked"] and hit["other_attacked"]) for hit in first),
        "collisions_with_wrecks": len(hard) - len(first),
        "slow_touches": len(end.collisions) - len(hard),
        "ttc_under_1_5_s": end.ttc,
        "drac_over_3_4_mps2": end.drac,
        "hard_brakings": totals.hard_brakings,
        "alarms": totals.alarms,
        "stops": totals.stops - end.mrm,
        "handovers": totals.handovers,
        "mrm": end.mrm,
        "stuck": end.stuck,
        "removed": end.removed,
        "surplus_share": end.surplus_share,
    }


def _with_stories(events: pd.DataFrame, stories: Sequence[Mapping[str, Any]], defence: str) -> pd.DataFrame:
    """Return `events` with what truly happened to each vehicle, the same for all defences, of which one steered."""
    told = pd.DataFrame(
        stories, columns=["vehicle_id", *(name for name in STORY_COLUMNS if name != "open_loop_outcome")]
    )
    steered = events[events["defence"] == defence]
    told["open_loop_outcome"] = told["vehicle_id"].map(
        dict(zip(steered["vehicle_id"], steered["outcome"], strict=True))
    )
    joined = events.merge(told, on="vehicle_id", how="left", validate="many_to_one")
    return joined[[*events.columns, *STORY_COLUMNS]]

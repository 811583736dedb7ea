"""A road on which somebody was stopped, in space and time: where each vehicle was, and where they stood."""

from collections.abc import Hashable, Mapping
from math import nan
from typing import Any

import numpy as np
import pandas as pd

from gpsec.outcomes.effects import BENIGN_PLAN
from gpsec.outcomes.true_outcomes import STANDING_MPS
from gpsec.report.figure_data import Figure, Series
from gpsec.report.worlds_names import attack_name, by_world, where, world_label
from gpsec.running.results import Results
from gpsec.types.constants import UNDEFENDED

# A line ends where a vehicle was not seen for so many periods.
_GAP_PERIODS = 1.5


def road_figure(run: Results) -> Figure:
    """Return the space-time diagram of one road of each world: that on which the most standing time was caused."""
    series: list[Series] = []
    stood = _standing(run)
    for world, rows in by_world(run.worlds["jams"]):
        if attack_name(world) == BENIGN_PLAN:
            continue
        caused_s = {str(name): _caused_s(stood, world, mine) for name, mine in rows.groupby("run", sort=False)}
        chosen = max(caused_s, key=lambda name: caused_s[name])
        series += _road(world, rows[rows["run"] == chosen], caused_s[chosen])
    return Figure(
        "road",
        "A road on which somebody was stopped",
        "simulated time (s)",
        "way along the road (m)",
        series,
        "Nobody was stopped in a world with this attack: there was no wreck, and nobody braked on an alarm.",
        "Of the roads on which a wreck stood, or a vehicle that braked on an alarm, each world keeps the one on which"
        " vehicles stood longest, from 20 s before that on. Shown is the seed in which the attack caused most standing"
        " time there: so much more than in the benign twin. All lanes of the direction, and vehicles beside them.",
        tall=True,
    )


def _standing(run: Results) -> dict[tuple[Hashable, ...], float]:
    """Return the time for which vehicles stood: (scenario, seed, plan, defence, reaction, rate, road) -> seconds."""
    found: dict[tuple[Hashable, ...], float] = {}
    for world, rows in by_world(run.worlds["standing"]):
        for seed, road, standing_s in zip(rows["seed"], rows["road"], rows["standing_s"], strict=True):
            found[(*_key(world), int(seed), road)] = float(standing_s)
    return found


def _key(world: Mapping[str, Any], plan: str | None = None, defence: str | None = None) -> tuple[Hashable, ...]:
    rate = world["false_alarms_per_h"] if plan is None else 0.0
    return world["scenario"], plan or world["plan"], defence or world["defence"], world["on_alarm"], rate


def _caused_s(stood: Mapping[tuple[Hashable, ...], float], world: Mapping[str, Any], rows: pd.DataFrame) -> float:
    """Return the standing time on the road of (n,) samples of one run, less that of its benign twin."""
    at = int(rows["seed"].iloc[0]), rows["road"].iloc[0]
    mine = stood.get((*_key(world), *at), 0.0)
    twins = [_key(world, BENIGN_PLAN), _key(world, BENIGN_PLAN, UNDEFENDED)]
    return mine - next((stood[(*twin, *at)] for twin in twins if (*twin, *at) in stood), 0.0)


def _road(world: Mapping[str, Any], rows: pd.DataFrame, caused_s: float) -> list[Series]:
    road, seed = rows["road"].iloc[0], int(rows["seed"].iloc[0])
    label = f"{world_label(world)}: road {road}, seed {seed}, {caused_s:+.0f} s of standing"
    place = {**where(world), "world": label}
    rows = rows.sort_values(["vehicle", "time_s"], kind="stable")
    x, y = _lines(rows)
    standing = rows[(rows["speed_mps"] < STANDING_MPS) & ~rows["stopped"]]
    attacked = rows[rows["attacked"] & (rows["speed_mps"] >= STANDING_MPS)]
    halted = rows[rows["stopped"] & (rows["speed_mps"] < STANDING_MPS)]
    made = [Series("vehicles", "line", x, y, where=place)]
    for name, some, colour, mark in (
        ("under attack", attacked, 1, "circle"),
        ("stands", standing, 0, "circle"),
        ("wreck, or stopped on an alarm", halted, 4, "square"),
    ):
        if len(some):
            points = some["time_s"].to_numpy(), some["position_m"].to_numpy()
            made.append(Series(name, "points", *points, colour=colour, where=place, mark=mark))
    return made


def _lines(rows: pd.DataFrame) -> tuple[list[float], list[float]]:
    """Return the ways of vehicles as one line, with a gap after each and where one was away."""
    time_s, vehicle = rows["time_s"].to_numpy(), rows["vehicle"].to_numpy()
    period_s = float(np.median(np.diff(np.unique(time_s)))) if len(np.unique(time_s)) > 1 else 1.0
    ends = np.flatnonzero((np.diff(vehicle) != 0) | (np.diff(time_s) > _GAP_PERIODS * period_s)) + 1
    x, y = (np.insert(rows[name].to_numpy(np.float64), ends, nan) for name in ("time_s", "position_m"))
    return x.tolist(), y.tolist()

"""The streets on which most vehicles would have left their lane, for the time that was driven there."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from gpsec.outcomes.metrics import poisson_interval
from gpsec.outcomes.ranking import Ranking, of_group
from gpsec.report.figure_data import group_name
from gpsec.report.map import lines_of_edges
from gpsec.running.results import Results
from gpsec.types.constants import UNDEFENDED

# So many are listed.
_MOST = 10


@dataclass(frozen=True)
class Street:
    """A street of the list.

    Attributes:
        group: scenario and profile; edge: SUMO's id.
        departures: of attacked vehicles, undefended; best: likewise with the first of the best defences.
        hours: that attacked vehicles drove there.
        rate, low, high: departures an hour driven, undefended, with the exact bounds of a count at 95 %.
        x_m, y_m: middle of the street in the net's own coordinates; lon_deg, lat_deg: the same.
        reach_m: from there to its farthest point.
    """

    group: str
    edge: str
    departures: int
    best: int
    hours: float
    rate: float
    low: float
    high: float
    x_m: float
    y_m: float
    lon_deg: float
    lat_deg: float
    reach_m: float


def worst_streets(run: Results, ranked: Sequence[Ranking]) -> list[Street]:
    """Return the streets of each ranking with the largest lower bounds of the rate of departures, undefended.

    By the lower bound, one departure in a short time does not come before many in a long one. The attacks are those
    that the ranking judges; streets that the map does not show are left out.
    """
    return [street for ranking in ranked if ranking.best for street in _of_ranking(run, ranking)]


def _of_ranking(run: Results, ranking: Ranking) -> list[Street]:
    mine = of_group(run.streets, ranking.scenario, ranking.profile)
    mine = mine[mine["attack"].isin(ranking.attacks)]
    # Not as categories: where no row is left, codes are bytes, however many streets there are to look up.
    mine = mine.assign(edge=mine["edge"].astype(object))
    plain = mine[mine["defence"] == UNDEFENDED]
    found = plain.groupby("edge", observed=True)[["departures", "vehicle_seconds"]].sum()
    found = found[found["departures"] > 0]
    hours = found["vehicle_seconds"].to_numpy() / 3600.0
    low, high = poisson_interval(found["departures"].to_numpy(), hours, 0.95)
    found = found.assign(hours=hours, low=low.value, high=high.value)
    found = found.sort_values(["low", "departures"], ascending=False, kind="stable")
    best = mine[mine["defence"] == ranking.best[0]].groupby("edge", observed=True)["departures"].sum()
    shapes = lines_of_edges(run, ranking.scenario)
    made = []
    for edge, row in found[found.index.isin(list(shapes))].head(_MOST).iterrows():
        made.append(
            _street(group_name(ranking.scenario, ranking.profile), str(edge), row, int(best.get(edge, 0)), shapes)
        )
    return made


def _street(
    group: str, edge: str, row: "pd.Series[float]", best: int, shapes: dict[str, tuple[np.ndarray, np.ndarray]]
) -> Street:
    metres, degrees = shapes[edge]
    middle, place = 0.5 * (metres.min(axis=0) + metres.max(axis=0)), 0.5 * (degrees.min(axis=0) + degrees.max(axis=0))
    reach = float(np.hypot(*(metres - middle).T).max())
    departures, hours = int(row["departures"]), float(row["hours"])
    bounds = float(row["low"]), float(row["high"])
    (x, y), (lon, lat) = middle.tolist(), place.tolist()
    return Street(group, edge, departures, best, hours, departures / hours, *bounds, x, y, lon, lat, reach)

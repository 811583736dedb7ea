"""Whether departures gather on one street, more than the time that vehicles drove there accounts for."""

from dataclasses import dataclass

import pandas as pd

from gpsec.outcomes.places import LEFT_LANE
from gpsec.outcomes.ranking import Ranking, Tables, of_group
from gpsec.types.constants import UNDEFENDED

# A street stands out with so many vehicles, that share of all, and a chance that small over all streets.
_FEWEST_VEHICLES = 3
_LEAST_SHARE = 0.3
_CHANCE = 0.01


@dataclass(frozen=True)
class Gathering:
    """A street on which departures gather.

    Attributes:
        edge: SUMO's id.
        defence: with which vehicles left their lane.
        vehicles: that did so there first; of: wherever.
        exposure_share: of the time that attacked vehicles drove, there.
        chance: probability of so many there if exposure were all that counts, times the number of streets.
    """

    edge: str
    defence: str
    vehicles: int
    of: int
    exposure_share: float
    chance: float

    def sentence(self) -> str:
        """Say it in words."""
        with_ = "undefended" if self.defence == UNDEFENDED else f"with {self.defence}"
        return (
            f"{self.vehicles} of the {self.of} vehicles that would have left their lane {with_} did so on one street,"
            f" {self.edge}, which has {100.0 * self.exposure_share:.1f} % of the time driven under and after"
            " attacks."
        )


def gatherings(tables: Tables, ranking: Ranking) -> list[Gathering]:
    """Return the streets that stand out, undefended and with the first of the best defences.

    `tables` holds ``streets`` and ``places``. The attacks are those that the ranking judges. A vehicle counts once a
    street, whatever the number of its plans; the chance is that of a binomial draw by exposure, times the number of
    streets with any (Bonferroni).
    """
    if not ranking.best:
        return []
    streets = of_group(tables["streets"], ranking.scenario, ranking.profile)
    streets = streets[streets["attack"].isin(ranking.attacks) & (streets["defence"] == UNDEFENDED)]
    driven = streets.groupby("edge", observed=True)["vehicle_seconds"].sum()
    driven = driven[~driven.index.astype(str).str.startswith(":")]
    places = of_group(tables["places"], ranking.scenario, ranking.profile)
    left = places[(places["what"] == LEFT_LANE) & places["attack"].isin(ranking.attacks)]
    found = (
        _of_defence(left[left["by"] == defence], defence, driven)
        for defence in dict.fromkeys([UNDEFENDED, ranking.best[0]])
    )
    return [one for one in found if one is not None]


def _of_defence(left: pd.DataFrame, defence: str, driven: "pd.Series[float]") -> Gathering | None:
    from scipy.stats import binom

    once = left.drop_duplicates(["scenario", "vehicle_id", "edge"])
    counts = once["edge"].astype(str).value_counts()
    total = int(counts.sum())
    found = None
    for edge, vehicles in counts.items():
        share = float(driven.get(edge, 0.0) / driven.sum()) if len(driven) else 0.0
        chance = float(binom.sf(vehicles - 1, total, share)) * len(driven)
        enough = vehicles >= _FEWEST_VEHICLES and vehicles >= _LEAST_SHARE * total
        if enough and chance < _CHANCE and (found is None or chance < found.chance):
            found = Gathering(str(edge), defence, int(vehicles), total, share, chance)
    return found

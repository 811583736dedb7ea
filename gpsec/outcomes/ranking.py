"""Ranks the defences of a run by vehicles out of their lane: one answer for the terminal, the report and the papers."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from gpsec.core.arrays import Floats, Ints
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.metrics import wilson_interval
from gpsec.outcomes.naming import base_name
from gpsec.outcomes.paired import PairedDifference, against_best, resampled_means, shares_of_vehicles
from gpsec.outcomes.state import LINE_TOUCHED, OUTCOMES
from gpsec.types.constants import UNDEFENDED

# Worst outcomes that imply that the lane was left.
OUT = frozenset(OUTCOMES[LINE_TOUCHED + 1 :])
# An attack acts along the road where its errors along it are that many times those across it.
_ALONG = 3.0
# Detectors that know the truth; what they do is no choice.
_TOLD = "told+"
Tables = Mapping[str, pd.DataFrame]


@dataclass(frozen=True)
class Standing:
    """What a defence leaves, as the mean over vehicles of the share of their attacks that put them out of their lane.

    Attributes:
        defence: detector+response.
        share, low, high: that mean, and its interval.
        against: the best defence, in pairs; also of those that are no choice.
        line_events: attacks under which the undefended vehicle would have touched a line.
        in_time_share: of these, the alarm came before the line.
        before_line_s: median time from the alarm to the line, of those; NaN where there is none.
        false_alarms_per_h: of a vehicle without an attack.
        without_gnss_min_per_h: likewise, minutes without GNSS.
    """

    defence: str
    share: float
    low: float
    high: float
    against: PairedDifference
    line_events: int
    in_time_share: float
    before_line_s: float
    false_alarms_per_h: float
    without_gnss_min_per_h: float


@dataclass(frozen=True)
class Ranking:
    """The defences of a scenario and sensor profile.

    Attributes:
        scenario, profile: names.
        vehicles: attacked in one of `attacks`, the unit of all that follows.
        attacks: plans that are judged together.
        apart: plan -> why it stands apart: ``along the road``, or ``nothing to compare``.
        standings: of all defences, by name, in the order of the run.
        best: those that cannot be told apart from the one with the smallest share, which is the first.
        vehicle_hours: without an attack, in which false alarms were counted.
        note: why nothing is judged; empty where it is.
    """

    scenario: str
    profile: str
    vehicles: int
    attacks: tuple[str, ...]
    apart: Mapping[str, str]
    standings: Mapping[str, Standing]
    best: tuple[str, ...]
    vehicle_hours: float = 0.0
    note: str = ""

    @property
    def undefended(self) -> Standing | None:
        """The vehicle without a defence; None where nothing was attacked."""
        return self.standings.get(UNDEFENDED)

    @property
    def helps(self) -> bool:
        """Whether the best defences are better than none."""
        return bool(self.best) and UNDEFENDED not in self.best

    @property
    def winner(self) -> str | None:
        """The one defence that is better than every other; None where there is none."""
        return self.best[0] if len(self.best) == 1 and self.helps else None


def candidates(defences: list[str]) -> list[str]:
    """Return the defences that one could drive with: at the headline rate, and not told the truth.

    Where all are at other rates, all of them.
    """
    real = [name for name in defences if not name.startswith(_TOLD)]
    headline = [name for name in real if "@" not in name]
    return headline if len(headline) > 1 else real


def rankings(tables: Tables, bootstrap: Bootstrap) -> list[Ranking]:
    """Return the ranking of each scenario and profile in `safety`; those over all seeds have the vehicles of all."""
    return [_ranking(tables, keys, rows, bootstrap) for keys, rows in _groups(tables["safety"])]


def _groups(safety: pd.DataFrame) -> Iterator[tuple[tuple[str, str], pd.DataFrame]]:
    for keys, rows in safety.groupby(["scenario", "profile"], sort=False, observed=True):
        scenario, profile = map(str, keys)
        yield (scenario, profile), rows


def of_group(table: pd.DataFrame, scenario: str, profile: str) -> pd.DataFrame:
    """Return the rows of a scenario and profile, of all its runs where `scenario` is the name over several seeds."""
    names = table["scenario"].astype(str)
    mine = names == scenario
    if not mine.any():
        mine = names.map(base_name) == scenario
    return table[mine & (table["profile"] == profile)]


def _ranking(tables: Tables, keys: tuple[str, str], safety: pd.DataFrame, bootstrap: Bootstrap) -> Ranking:
    scenario, profile = keys
    events = of_group(tables["events"], scenario, profile)
    notes = [note for note in safety["note"].dropna() if note]
    if notes or events.empty:
        return _unjudged(keys, {}, str(notes[0]) if notes else "no vehicle was attacked")
    apart = stands_apart(events)
    attacks = tuple(str(name) for name in events["attack"].unique() if str(name) not in apart)
    judged = events[events["attack"].isin(attacks)]
    if judged.empty:
        return _unjudged(keys, apart, "no attack acts across the road")
    defences = list(dict.fromkeys(judged["defence"].astype(str)))
    shares, runs = _per_vehicle(judged, defences)
    means = resampled_means(shares, runs, bootstrap, f"{profile}/ranking")
    choice = [defences.index(name) for name in candidates(defences)]
    first, differences = against_best(shares, means, choice, bootstrap.confidence)
    bounds = _bounds(shares, means, bootstrap.confidence)
    costs = Costs.of(tables["detection"], safety, keys)
    standings = {}
    for column, name in enumerate(defences):
        share, low, high = (float(bound[column]) for bound in bounds)
        standings[name] = Standing(
            name, share, low, high, differences[column], *in_time(judged, name), *costs.of_defence(name)
        )
    group = [column for column in choice if not differences[column].apart]
    best = [
        defences[column] for column in sorted(group, key=lambda column: (column != first, shares[:, column].mean()))
    ]
    return Ranking(scenario, profile, len(runs), attacks, apart, standings, tuple(best), costs.vehicle_hours)


def _unjudged(keys: tuple[str, str], apart: Mapping[str, str], note: str) -> Ranking:
    return Ranking(*keys, 0, (), apart, {}, (), note=note)


def stands_apart(events: pd.DataFrame) -> dict[str, str]:
    """Return the plans that a comparison of lanes cannot judge, with the reason.

    An attack is *along the road* where the median undefended vehicle errs `_ALONG` times more along than across it;
    with *nothing to compare* no detector scored a sample under it.
    """
    found = {}
    plain = events[events["defence"] == UNDEFENDED]
    scored = (events["true_positives"] + events["false_negatives"]).groupby(events["attack"], observed=True).sum()
    for attack, rows in plain.groupby("attack", sort=False, observed=True):
        across, along = rows["rmse_cross_track_m"], rows["rmse_along_track_m"]
        if not scored[attack]:
            found[str(attack)] = "nothing to compare"
        elif (along > _ALONG * across).mean() > 0.5:
            found[str(attack)] = "along the road"
    return found


def _per_vehicle(events: pd.DataFrame, defences: list[str]) -> tuple[Floats, Ints]:
    """Return the (V, D) shares of the attacks on each vehicle that put it out of its lane, and (V,) runs."""
    known = events["scenario"].astype(str) + "\0" + events["vehicle_id"].astype(str)
    vehicle, names = pd.factorize(known)
    runs, _ = pd.factorize(pd.Series(names).str.partition("\0")[0])
    defence = events["defence"].astype(str).map(defences.index).to_numpy()
    out = events["outcome"].isin(OUT).to_numpy()
    shape = len(names), len(defences)
    return shares_of_vehicles(vehicle.astype(np.int32), defence, out, shape), runs.astype(np.int32)


def _bounds(shares: Floats, means: Floats, confidence: float) -> tuple[Floats, Floats, Floats]:
    """Return (D,) means and their bounds; where no vehicle left its lane, that of so many vehicles without one."""
    tail = 0.5 * (1.0 - confidence)
    mean, low, high = shares.mean(axis=0), *np.quantile(means, [tail, 1.0 - tail], axis=0)
    none = wilson_interval(np.zeros(len(mean)), np.full(len(mean), len(shares)), confidence)[1].value
    return mean, low, np.where(mean > 0.0, high, none)


def in_time(events: pd.DataFrame, defence: str) -> tuple[int, float, float]:
    """Return how many attacks let the undefended vehicle touch a line, the share seen before, and by how much."""
    event = ["scenario", "vehicle_id", "attack"]
    line = events[(events["defence"] == UNDEFENDED) & events["time_to_line_s"].notna()].set_index(event)
    seen = events[events["defence"] == defence].set_index(event)["detection_delay_s"]
    lead = (line["time_to_line_s"] - seen.reindex(line.index)).to_numpy()
    before = lead[lead > 0.0]
    if not len(line):
        return 0, np.nan, np.nan
    return len(line), len(before) / len(line), float(np.median(before)) if len(before) else np.nan


@dataclass(frozen=True)
class Costs:
    """What defences cost vehicles that nobody attacks: false alarms by detector, minutes without GNSS by defence."""

    false_alarms_per_h: Mapping[str, float]
    without_gnss_min_per_h: Mapping[str, float]
    vehicle_hours: float

    @classmethod
    def of(cls, detection: pd.DataFrame, safety: pd.DataFrame, keys: tuple[str, str]) -> "Costs":
        """Return those of a scenario and profile."""
        mine = detection[(detection["scenario"] == keys[0]) & (detection["profile"] == keys[1])]
        alarms = zip(mine["detector"].astype(str), mine["false_alarms_per_vehicle_hour"], strict=True)
        minutes = zip(safety["defence"].astype(str), safety["isolated_minutes_per_vehicle_hour"], strict=True)
        return cls(dict(alarms), dict(minutes), float(mine["vehicle_hours"].max()))

    def of_defence(self, name: str) -> tuple[float, float]:
        """Return both of one defence; NaN where the run does not tell."""
        detector = name.partition("+")[0]
        return self.false_alarms_per_h.get(detector, np.nan), self.without_gnss_min_per_h.get(name, np.nan)

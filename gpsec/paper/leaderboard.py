"""The table of detectors: a row for each detector, sensor profile, world, false-alarm rate and attacker."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from gpsec.core import shipped
from gpsec.core.errors import GpsecError
from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.naming import seeded_name
from gpsec.outcomes.seeds import pooled
from gpsec.outcomes.tables import read_table, whole, write_frame
from gpsec.paper.suite import RESPONSE, Candidate, Suite
from gpsec.running.impact import impact_table
from gpsec.scenario.detection import Defence
from gpsec.types.points import point_name

LEADERBOARD = "leaderboard.csv"
_BOOTSTRAP = Bootstrap(2026)
_READ = ("events", "vehicles", "detection", "localization", "safety")
_FROM_IMPACT = (
    *("false_alarms_per_vehicle_hour", "detected_share", "max_undetected_deviation_median_m"),
    *("line_touched_unseen_share", "out_of_lane_unseen_share"),
)
_FROM_SAFETY = ("line_touched_caused_share", "out_of_lane_caused_share", "isolated_minutes_per_vehicle_hour")
_KEYS = ("suite", "detector", "profile", "world", "rate", "attack")


def _with_bounds(names: Sequence[str]) -> list[str]:
    return [f"{name}{end}" for name in names for end in ("", "_lo", "_hi")]


LEADERBOARD_COLUMNS = (
    *_KEYS,
    "n_runs",
    "n_vehicles",
    *_with_bounds((*_FROM_IMPACT, *_FROM_SAFETY)),
    "us_per_track_step",
)


def reference_leaderboard() -> Path:
    """Return where the rows of gpsec's own detectors are, if they are."""
    return shipped.home() / "results" / "reference" / LEADERBOARD


def suite_rows(
    suite: Suite, candidate: Candidate, folders: Mapping[str, Sequence[Path]], cost_us: float
) -> pd.DataFrame:
    """Return the rows of a detector over all runs of each world, with intervals of runs, then vehicles.

    Args:
        suite: that was run.
        candidate: the detector.
        folders: of the runs, by world.
        cost_us: what the detector costs, in µs a track-step.
    """
    rows = [
        {"suite": suite.name, "detector": candidate.detector, "profile": candidate.profile, "world": world}
        | row
        | {"us_per_track_step": cost_us}
        for world, members in folders.items()
        for row in _of_world(suite, candidate, members)
    ]
    return pd.DataFrame(rows, columns=list(LEADERBOARD_COLUMNS))


def _of_world(suite: Suite, candidate: Candidate, folders: Sequence[Path]) -> Iterator[dict[str, Any]]:
    tables = {name: pd.concat(_parts(folders, name), ignore_index=True) for name in _READ}
    impact = impact_table(tables, _BOOTSTRAP)
    safety = pooled("suite", tables, _BOOTSTRAP)["safety"]
    for rate in suite.rates:
        point = point_name(candidate.detector, rate)
        defence = Defence(detector=candidate.detector, response=RESPONSE, rate=rate).name
        for attack in suite.attacks:
            # An attacker who knows a detector knows its threshold, too.
            plan = f"{attack}@{rate}" if attack.startswith("adaptive") else attack
            for mine in impact[(impact["attack"] == plan) & (impact["detector"] == point)].to_dict("records"):
                row = {"rate": rate, "attack": attack, "n_runs": mine["n_runs"], "n_vehicles": mine["n_events"]}
                kept = safety[(safety["attack"] == plan) & (safety["defence"] == defence)].iloc[0]
                row |= {name: mine[name] for name in _with_bounds(_FROM_IMPACT)}
                yield row | {name: kept[name] for name in _with_bounds(_FROM_SAFETY)}


def _parts(folders: Sequence[Path], name: str) -> Iterator[pd.DataFrame]:
    """Yield a table of each run, named as if all were seeds of one scenario."""
    for number, folder in enumerate(folders):
        found = read_table(folder, name)
        yield found.assign(scenario=seeded_name("suite", number))


def read_leaderboard(path: Path) -> pd.DataFrame:
    """Return the rows of a leaderboard, none where there is none.

    Raises:
        GpsecError: it is not one of this version.
    """
    if not path.is_file():
        return pd.DataFrame(columns=list(LEADERBOARD_COLUMNS))
    texts = dict.fromkeys(_KEYS, str)
    try:
        found = pd.read_csv(path, dtype=texts, keep_default_na=False, na_values=[""])
    except (OSError, ValueError):
        found = pd.DataFrame()
    if tuple(found.columns) != LEADERBOARD_COLUMNS:
        raise GpsecError(f"{path}: expected a leaderboard with the columns of this version, found another file")
    return found


def enter(rows: pd.DataFrame, out: Path) -> pd.DataFrame:
    """Put the rows of a detector into the leaderboard of a folder, which begins with the shipped ones; return it.

    Raises:
        GpsecError: what the folder holds is no leaderboard of this version.
    """
    path = out / LEADERBOARD
    former = read_leaderboard(path if path.is_file() else reference_leaderboard())
    mine = rows.drop_duplicates(["suite", "detector", "profile"])
    again = pd.Series(False, index=former.index)
    for suite, detector, profile in mine[["suite", "detector", "profile"]].itertuples(index=False, name=None):
        again |= (former["suite"] == suite) & (former["detector"] == detector) & (former["profile"] == profile)
    kept = former[~again]
    table = pd.concat([kept, rows], ignore_index=True) if len(kept) else rows
    with whole(path) as partial:
        write_frame(table, partial)
    return table

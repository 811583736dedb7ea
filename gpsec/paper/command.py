"""`gpsec paper`: runs what is missing, and makes tables, figures and a page of it."""

from collections.abc import Sequence
from itertools import product
from pathlib import Path

import pandas as pd

from gpsec.core.progress import Progress, Report
from gpsec.outcomes.paper import TABLES_II_TO_IV, PublishedRmse
from gpsec.outcomes.tables import whole
from gpsec.paper import figures, page, pool, tables
from gpsec.paper.design import (
    CONSTANT_BIAS,
    CROWDED,
    EVALUATION,
    FURTHER_RATES,
    ODOMETER_FACTORS,
    ODOMETER_PROFILE,
    SET_UPS,
    SIMULATED,
    STEALTH,
)
from gpsec.paper.filter_consistency import TABLE, evaluate, gather
from gpsec.paper.pinning import pin
from gpsec.paper.runs import RUNS, Runs, run_missing, write_runs
from gpsec.paper.studies import Studies
from gpsec.scenario.networks import TRAINING_NETWORKS
from gpsec.sensors.registry import PROFILES

TABLE_ATTACKS = {CONSTANT_BIAS: CONSTANT_BIAS, STEALTH: STEALTH}


def make(out: Path, studies: Studies, jobs: int, report: Report) -> None:
    """Make the tables in `out` from runs in ``out/runs``; runs that are there already are kept.

    Raises:
        GpsecError: a scenario is missing, or cannot be run.
        KeyboardInterrupt: the user has had enough.
    """
    runs = run_all(out / RUNS, studies, jobs, report)
    benign = run_missing(studies.benign(), out / RUNS, jobs, report, evaluate)
    report(Progress("tables", stage="pooling events"))
    consistency = gather(benign)
    with whole(out / TABLE) as partial:
        consistency.to_csv(partial, index=False, lineterminator="\n", encoding="utf-8")
    tables.write_pinned(runs.pinned, out / "pinned.csv")
    table_1 = table_one(runs)
    tables.write_tidy(table_1, out / "table1.csv")
    made = {1: table_1}
    for number, published in enumerate(TABLES_II_TO_IV, start=2):
        made[number] = rmse_table(runs, published)
        tables.write_table(made[number], out / f"table{number}.csv")
    made[0] = list(tables.odometer_rows(odometer_events(runs)))
    tables.write_table(made[0], out / "odometer.csv")
    report(Progress("tables", stage="drawing figures"))
    drawn = figures.draw_figures(runs, out / "figures")
    page.write_readme(out / "README.md", runs.pinned, made, consistency, drawn)
    write_runs(out / "manifest.json", runs)


def run_all(folder: Path, studies: Studies, jobs: int, report: Report) -> Runs:
    """Run what is missing and return where everything is."""
    pinned = pin(run_missing(studies.pin(), folder, jobs, report))
    groups = studies.groups(pinned)
    # All at once, so that no process waits for the last run of a group.
    run_missing([scenario for group in groups.values() for scenario in group], folder, jobs, report)
    return Runs(pinned, {key: [folder / scenario.name for scenario in group] for key, group in groups.items()})


def table_one(runs: Runs) -> list[tables.PaperRow]:
    """Return Table I: set-ups and rates, roads of several lanes, generalisation."""
    rows: list[tables.PaperRow] = []
    for profile, network in SET_UPS.items():
        label = f"{profile} on {network}"
        rows += tables.detection_rows(tables.at(label), *_both(runs.of("main", profile)), TABLE_ATTACKS)
        rows += tables.detection_rows(
            tables.at(label, association="nearest"), *_both(runs.of("nearest", profile)), TABLE_ATTACKS
        )
        rows += tables.detection_rows(
            tables.at(f"{tables.WRITTEN} / {label}", association="nearest"),
            *_both(runs.of("written", profile)),
            TABLE_ATTACKS,
        )
        for rate in FURTHER_RATES:
            rows += tables.detection_rows(tables.at(label, rate), *_both(runs.of("rate", profile, rate)), TABLE_ATTACKS)
    for association, network in product(("tracked", "nearest"), CROWDED):
        events, vehicles = _both(runs.of("mixed", association, network))
        for profile in SET_UPS:
            mine, theirs = events[events["profile"] == profile], vehicles[vehicles["profile"] == profile]
            named = {attack: f"{attack}_{profile}" for attack in TABLE_ATTACKS}
            label = tables.at(f"{profile} on {network}", association=association)
            rows += tables.detection_rows(label, mine, theirs, named)
        rows += tables.alias_rows(f"{network} / {association}", events)
    trained, unseen = (
        pool.read_runs([folder for network in networks for folder in runs.of("mixed", "tracked", network)], "events")
        for networks in (TRAINING_NETWORKS, EVALUATION)
    )
    rows += tables.generalisation_rows(trained, unseen)
    return rows


def rmse_table(runs: Runs, published: PublishedRmse) -> list[tables.PaperRow]:
    """Return one of Tables II to IV: with a real car's sensors, as written, and with what its simulator gives."""
    profile = published.profile

    def events(*group: str) -> pd.DataFrame:
        return pool.read_runs(runs.of(*group), "events")

    rows = tables.localization_rows(published, events("main", profile))
    rows += tables.localization_rows(published, events("written", profile), tables.WRITTEN)
    if profile in SIMULATED:
        rows += tables.localization_rows(published, events("simulated", profile), tables.SIMULATOR)
        label = f"{tables.SIMULATOR}, {tables.WRITTEN}"
        rows += tables.localization_rows(published, events("written", SIMULATED[profile]), label)
    return rows


def odometer_events(runs: Runs) -> dict[float, pd.DataFrame]:
    """Return the events of the sweep over the odometer's scale error, by that (a standard deviation, as a ratio)."""
    stated = PROFILES[ODOMETER_PROFILE].odometer.scale_ratio
    return {f * stated: pool.read_runs(runs.of("odometer", f"{f:g}"), "events") for f in ODOMETER_FACTORS}


def _both(folders: Sequence[Path]) -> tuple[pd.DataFrame, pd.DataFrame]:
    return pool.read_runs(folders, "events"), pool.read_runs(folders, "vehicles")

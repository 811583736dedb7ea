"""One simulation in the place of many: its rows are those of runs of their own, and one dataset holds all of them."""

import shutil
from pathlib import Path

import pandas as pd
import pytest

import gpsec
from gpsec.report.sweep_page import axis_of, write_sweep
from gpsec.scenario import Scenario
from gpsec.sweeps.desk import run_as_listed
from gpsec.sweeps.folder import SweepFolder, read_folder, write_list
from gpsec.sweeps.gather import gather_tables
from gpsec.sweeps.listing import listed
from gpsec.sweeps.plan import read_plan
from gpsec.sweeps.results import Sweep
from gpsec.sweeps.work import missing

HEAD = """
[set]
duration_s = 35.0
fleet.settle_s = 3.0
fleet.camera.visibility = "clock"
outcomes.bootstrap = 20
defences = [{ detector = "cusum", response = "ukf" }]
"""
PLAN = f"""{HEAD}
plans = [{{ attack = "stealth", start_after_s = [0.0, 3.0] }}, {{ attack = "drift", share = 0.3 }}]

[[entries]]
name = "shares"
scenarios = ["slow_curve"]
seeds = [2]

[entries.grid]
fleet.equipped_share = [0.7, 1.0]
plans.stealth.delta = [1.2, 1.6]
plans.stealth.share = [0.6, 1.0]
"""
ALONE = f"""{HEAD}
fleet.equipped_share = 0.7
plans = [{{ attack = "stealth", start_after_s = [0.0, 3.0], delta = 1.6, share = 0.6 }}]

[[entries]]
name = "alone"
scenarios = ["slow_curve"]
seeds = [2]
"""
DELTA, SHARE, EQUIPPED = "plans.stealth.delta", "plans.stealth.share", "fleet.equipped_share"


def run_here(folder: SweepFolder) -> None:
    """Make what is missing in this process: what starts the processes of workers is tested beside."""
    for fingerprint in missing(folder):
        claim = folder.store.claim(fingerprint)
        assert claim is not None
        claim.made.mkdir()
        told = folder.tasks(fingerprint)[0].told
        run_as_listed(Scenario.model_validate_json(told), claim.made, lambda progress: None)
        folder.store.publish(claim)


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> Sweep:
    path = tmp_path_factory.mktemp("sweep") / "plan.toml"
    path.write_text(PLAN)
    plan = read_plan(path)
    folder = write_list(path.with_name("made"), listed(plan, path), plan.parameters, None)
    run_here(folder)
    assert gather_tables(folder, lambda done, of: None) == []
    return Sweep(folder)


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Sweep:
    """Return the same with two seeds, made by workers."""
    path = tmp_path_factory.mktemp("swept") / "plan.toml"
    path.write_text(PLAN.replace("seeds = [2]", "seeds = [1, 2]"))
    return gpsec.sweep(path, path.with_name("made"), jobs=1)


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> gpsec.Results:
    """Return a run with the smaller shares, as a plan that lists nothing else has it."""
    path = tmp_path_factory.mktemp("alone") / "plan.toml"
    path.write_text(ALONE)
    plan = read_plan(path)
    folder = write_list(path.with_name("made"), listed(plan, path), plan.parameters, None)
    run_here(folder)
    (fingerprint,) = folder.labels
    return gpsec.load(folder.store.result(fingerprint))


def test_rows_of_a_smaller_share_are_those_of_a_run_of_its_own(sweep: Sweep, alone: gpsec.Results) -> None:
    wanted = alone.events[alone.events["attack"] == "stealth"]
    found = sweep.events
    found = found[(found["seed"] == 2) & (found["attack"] == "stealth") & (found[DELTA] == 1.6)]
    found = found[(found["share_draw"] < 0.6) & (found["equipped_draw"] < 0.7)]
    assert len(wanted) > 0
    pd.testing.assert_frame_equal(_plain(found, wanted), _plain(wanted, wanted))
    honest = sweep.vehicles[(sweep.vehicles["seed"] == 2) & (sweep.vehicles["attack"] == "none")]
    honest = honest[honest["equipped_draw"] < 0.7]
    wanted = alone.vehicles[alone.vehicles["attack"] == "none"]
    pd.testing.assert_frame_equal(_plain(honest, wanted), _plain(wanted, wanted))


@pytest.mark.parametrize("name", ["detection", "localization", "safety"])
def test_figures_of_a_smaller_share_are_those_of_a_run_of_its_own(
    sweep: Sweep, alone: gpsec.Results, name: str
) -> None:
    table, wanted = getattr(sweep, name), getattr(alone, name)
    mine = table[(table["seed"] == 2) & (table[EQUIPPED] == 0.7)]
    for attack, rows in (
        ("stealth", mine[(mine["attack"] == "stealth") & (mine[DELTA] == 1.6) & (mine[SHARE] == 0.6)]),
        ("none", mine[mine["attack"] == "none"]),
    ):
        # Detectors that no defence uses are in no row of a vehicle.
        by = "detector" if name == "detection" else "defence"
        theirs = wanted[(wanted["attack"] == attack) & wanted[by].isin(["never", "cusum", "never+none", "cusum+ukf"])]
        one, other = (_by(each, by)[sorted(_SUMMED & set(theirs))] for each in (rows, theirs))
        assert len(one) == 2
        # What is summed from events, which have nine digits.
        pd.testing.assert_frame_equal(one, other, rtol=1e-6, check_dtype=False)


def _by(table: pd.DataFrame, name: str) -> pd.DataFrame:
    return table.astype({name: str}).set_index(name).sort_index()


_SUMMED = {
    *("n_vehicles", "n_events", "n_line_events", "line_touched", "out_of_lane", "wrong_way", "off_road"),
    *("out_of_lane_share", "out_of_lane_caused_share", "precision", "recall", "f1", "delay_mean_s", "detected_share"),
    *("seen_before_line_share", "alarm_ends_after_mean_s", "rmse_xy_m", "twin_rmse_xy_m", "max_cross_track_m"),
    *("isolated_minutes_per_vehicle_hour", "false_alarms_per_vehicle_hour", "vehicle_hours"),
}


@pytest.mark.slow
def test_two_simulations_serve_sixteen_combinations(swept: Sweep) -> None:
    assert len(swept.tasks) == 2
    stealth = swept.safety[(swept.safety["attack"] == "stealth") & (swept.safety["defence"] == "cusum+ukf")]
    assert len(stealth[["seed", EQUIPPED, DELTA, SHARE]].drop_duplicates()) == len(stealth) == 16
    assert swept.safety[swept.safety["attack"] == "none"][[DELTA, SHARE]].isna().to_numpy().all()
    assert not [name for name in swept.safety if name.endswith("_lo")]


@pytest.mark.slow
def test_intervals_are_over_seeds(swept: Sweep) -> None:
    over = swept.over_seeds(50)["safety"]
    assert set(over["n_runs"]) == {2}
    row = over[(over["attack"] == "stealth") & (over["defence"] == "never+none") & (over[EQUIPPED] == 1.0)]
    row = row[(row[DELTA] == 1.2) & (row[SHARE] == 1.0)].iloc[0]
    mine = swept.events
    mine = mine[(mine["attack"] == "stealth") & (mine["defence"] == "never+none") & (mine[DELTA] == 1.2)]
    assert row["n_vehicles"] == len(mine)
    touched = mine["outcome"].isin(["line_touched", "out_of_lane", "wrong_way", "off_road"])
    assert row["line_touched_share"] == pytest.approx(touched.mean())
    assert row["line_touched_share_lo"] <= row["line_touched_share"] <= row["line_touched_share_hi"]


@pytest.mark.slow
def test_a_simulation_is_a_run_like_any_other(swept: Sweep, tmp_path: Path) -> None:
    run = swept.run(swept.tasks["fingerprint"][0])
    assert run.changed == {}
    assert set(run.events["attack"]) >= {"stealth~1", "stealth~2"}


@pytest.mark.slow
def test_duckdb_reads_the_dataset(swept: Sweep) -> None:
    duckdb = pytest.importorskip("duckdb")
    rows = duckdb.sql(
        f"""SELECT seed, "{DELTA}" AS delta, count(*) AS events
        FROM read_parquet('{swept.folder.path}/tables/events/*.parquet')
        WHERE attack = 'stealth' AND defence = 'never+none' AND share_draw < 0.6 GROUP BY ALL ORDER BY ALL"""
    ).fetchall()
    mine = swept.events
    mine = mine[(mine["attack"] == "stealth") & (mine["defence"] == "never+none") & (mine["share_draw"] < 0.6)]
    assert rows == [(*key, count) for key, count in mine.groupby(["seed", DELTA]).size().items()]


@pytest.mark.slow
def test_the_page_has_small_multiples(swept: Sweep) -> None:
    page = write_sweep(swept.folder.path)
    assert page is not None
    text = page.read_text("utf-8")
    assert "Vehicles that would leave their lane" in text
    assert text.count('class="multiples"') >= 3
    over = swept.over_seeds(10)["safety"]
    assert axis_of(over, {EQUIPPED: "text", DELTA: "number"}) == DELTA


@pytest.mark.slow
def test_a_run_that_was_spoilt_is_made_again(swept: Sweep, tmp_path: Path) -> None:
    shutil.copytree(swept.folder.path, tmp_path / "copy")
    copy = read_folder(tmp_path / "copy")
    fingerprint = next(iter(copy.labels))
    with (copy.store.result(fingerprint) / "events.csv").open("a") as file:
        file.write("by hand\n")
    shutil.rmtree(copy.path / "tables")
    assert gather_tables(copy, lambda done, of: None) == [fingerprint]
    assert not copy.store.has(fingerprint)


def _plain(table: pd.DataFrame, like: pd.DataFrame) -> pd.DataFrame:
    """Return rows in one order with the columns of a run, texts for categories, and without what tells runs apart."""
    columns = [name for name in like.columns if name != "scenario"]
    texts = [name for name in columns if not pd.api.types.is_numeric_dtype(like[name])]
    table = table[columns].astype(dict.fromkeys(texts, str))
    return table.sort_values(["vehicle_id", "defence"]).reset_index(drop=True)

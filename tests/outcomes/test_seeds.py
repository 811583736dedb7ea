"""Tables over several seeds: the figures of all vehicles, and intervals that know that runs differ."""

import numpy as np
import pandas as pd
import pytest

from gpsec.outcomes.bootstrap import Bootstrap
from gpsec.outcomes.merging import merge
from gpsec.outcomes.naming import base_name, seeded_name
from gpsec.outcomes.seeds import pooled_tables
from gpsec.outcomes.tables import TABLES, read_table

from .story import tell
from .test_tables import one


@pytest.fixture(scope="module")
def merged(tmp_path_factory):
    folder = tmp_path_factory.mktemp("seeds")
    for seed in (1, 2, 3):
        name = seeded_name("lane", seed)
        tell().outcomes.write(folder / name, name, seed, replicates=20)
        (folder / name / "manifest.json").write_text(f'{{"scenario": "{name}"}}')
    merge([folder / seeded_name("lane", seed) for seed in (1, 2, 3)], folder / "out")
    return folder


def test_names():
    assert base_name(seeded_name("a-seed-b", 12)) == "a-seed-b"
    assert base_name("town") == "town"


def test_three_times_the_same_run_is_three_times_its_vehicles(merged):
    alone = {name: read_table(merged / "lane-seed-1", name) for name in TABLES}
    pooled = {name: read_table(merged / "out", f"pooled_{name}") for name in ("detection", "localization", "safety")}
    for name, by in (("detection", "detector"), ("localization", "defence"), ("safety", "defence")):
        assert set(pooled[name]) == {*alone[name], "n_runs"}
        assert set(pooled[name]["scenario"]) == {"lane"}
        assert (pooled[name]["n_runs"] == 3).all()
        for row in pooled[name].to_dict("records"):
            theirs = one(alone[name], profile=row["profile"], attack=row["attack"], **{by: row[by]})
            for column in _FIGURES:
                if column in row and not (name == "localization" and row["attack"] == "none" and column in _NOT_NONE):
                    assert row[column] == pytest.approx(theirs[column], nan_ok=True, rel=1e-6), (name, column, row)
            for column in ("n_events", "n_vehicles", "line_touched", "off_road", "n_line_events"):
                if column in row and not pd.isna(row[column]):
                    assert row[column] == 3 * theirs[column], (name, column)


_FIGURES = (
    *("precision", "recall", "f1", "delay_mean_s", "detected_share", "detected_not_twin_share"),
    *("seen_before_line_share", "alarm_ends_after_mean_s", "false_alarms_per_vehicle_hour", "threshold"),
    *("rmse_x_m", "rmse_xy_m", "rmse_cross_track_m", "twin_rmse_xy_m", "max_cross_track_m"),
    *("line_touched_share", "out_of_lane_share", "line_touched_caused_share", "isolated_minutes_per_vehicle_hour"),
)
_NOT_NONE = ("rmse_x_m", "rmse_cross_track_m")


def test_a_run_without_siblings_is_not_pooled(merged):
    tables = {name: read_table(merged / "lane-seed-1", name) for name in TABLES}
    assert pooled_tables(tables, Bootstrap(1)) == {}


def test_whole_runs_are_drawn_and_in_them_vehicles():
    runs = np.repeat([0, 1, 2], [2, 5, 1]).astype(np.int32)
    weights = Bootstrap(3, 4000).weights("x", runs)
    assert weights.shape == (4000, 8)
    drawn = np.stack([weights[:, runs == run].sum(axis=1) for run in range(3)], axis=1)
    # A run that is drawn t times brings t times as many vehicles as it has, and three runs are drawn.
    assert ((drawn % [2, 5, 1]) == 0).all()
    assert (drawn / [2, 5, 1]).sum(axis=1).tolist() == [3.0] * 4000
    np.testing.assert_allclose(weights.mean(axis=0), 1.0, atol=0.06)


def test_what_a_run_has_in_common_widens_the_interval():
    # Ten runs of 50 vehicles, all of which leave their lane in every second run: over runs 0.5 ± 0.31, not ± 0.044.
    runs = np.repeat(np.arange(10), 50).astype(np.int32)
    left = (runs % 2).astype(float)
    bootstrap = Bootstrap(1, 2000)
    share = bootstrap.weights("x", runs) @ left / 500
    low, high = np.quantile(share, [0.025, 0.975])
    assert (low, high) == (pytest.approx(0.2, abs=0.05), pytest.approx(0.8, abs=0.05))
    single = bootstrap.weights("x", np.zeros(500, np.int32)) @ left / 500
    assert np.quantile(single, 0.975) == pytest.approx(0.544, abs=0.01)

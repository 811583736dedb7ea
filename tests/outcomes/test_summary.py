import json
from io import StringIO

import pandas as pd
import pytest
from rich.console import Console

from gpsec.outcomes.paper import TABLE_I, localization_like
from gpsec.outcomes.summary import print_summary
from gpsec.outcomes.tables import TABLES, merge, read_table

from .scene import Scene
from .story import tell

DETECTORS = ("chi_square", "cusum", "isolation_forest", "lstm", "oracle", "never")
DEFENCES = (
    ("never", "none"),
    ("cusum", "ukf"),
    ("isolation_forest", "dead_reckoning"),
    ("isolation_forest", "ukf"),
    ("lstm", "dead_reckoning"),
    ("lstm", "ukf"),
    ("oracle", "ukf"),
)
COSTS = {
    "sumo_s": 12.5,
    "read_s": 1.5,
    "stages_s": {"truth": 0.5, "detectors": 2.0, "filters": 7.5, "files": 0.25},
    "vehicle_steps": 1_000_000,
    "peak_vehicles": 512,
}


def printed(folder):
    stream = StringIO()
    print_summary(folder, Console(file=stream, width=120, color_system=None))
    return stream.getvalue()


@pytest.fixture(scope="module")
def summary(tmp_path_factory):
    """The summary of two scenarios with long names and large errors, as a run leaves them."""
    work = tmp_path_factory.mktemp("work")
    for scenario, error_m in (("slow_curve", 1234.5), ("town", 0.0123)):
        plans = ("none", "constant_bias", "stealth", "two_stage")
        scene = Scene(plan_names=plans, detector_names=DETECTORS, defences=DEFENCES, profile_names=("dsd",))
        scene.observe(0, [0])
        for plan in (1, 2, 3):
            scene.fork(0, plan, plan, 1)
        scene.alarm[1:, :4] = True
        scene.estimate_m[1:, :, 0] = error_m
        for step in range(1, 101):
            scene.observe(step, [0, 1, 2, 3])
        for row in range(4):
            scene.close(row, "v")
        scene.outcomes.write(work / scenario, scenario, 1, replicates=20)
        (work / scenario / "manifest.json").write_text(json.dumps({"scenario": scenario} | COSTS))
    merge(list(work.iterdir()), work / "out")
    return printed(work / "out")


def test_it_fits_120_columns_without_cutting(summary):
    assert max(map(len, summary.splitlines())) <= 120
    assert "…" not in summary


def test_paper_rows_stand_beside_ours(summary):
    rows = [line for line in summary.splitlines() if "0.98/1.00/0.99 0.0" in line]
    assert len(rows) == 2
    assert all("lstm" in row and "1.00 1.00–1.00" in row and "0.00 0.00–0.00" in row for row in rows)
    paper = next(line for line in summary.splitlines() if "paper, II (DSD)" in line)
    assert paper.split()[-2:] == ["1.52/1.54/2.16", ".012/.025/.032"]
    assert summary.count("paper, II (DSD)") == 2  # seven defences make two tables; town is not in the paper


def test_errors_and_counts_are_there(summary):
    assert "1234/.000/1234" in summary or "1235/.000/1235" in summary
    assert ".012/.000/.012" in summary
    assert "constant_bias (1)" in summary
    assert "0/0/0/0" in summary


def test_costs_are_for_every_vehicle_step(summary):
    row = next(line for line in summary.splitlines() if "1,000,000" in line)
    assert row.split()[:8] == ["slow_curve", "12.5", "1.5", "10.2", "1,000,000", "512", "12.5", "10.2"]
    assert "filters 7.5, detectors 2.0, truth 0.5" in row


def test_large_counts_take_more_tables_instead_of_being_cut(tmp_path):
    tell().outcomes.write(tmp_path, "lane", 1, replicates=5)
    safety = read_table(tmp_path, "safety")
    safety = pd.concat([safety.assign(defence=safety["defence"] + str(i)) for i in range(4)])
    safety[["line_touched", "out_of_lane", "wrong_way", "off_road"]] = 123_456
    safety.to_csv(tmp_path / "safety.csv", index=False)
    (tmp_path / "manifest.json").write_text("{}")
    text = printed(tmp_path)
    assert text.count("123456/123456/123456/123456") == 2 * 8
    assert max(map(len, text.splitlines())) <= 120


def test_runs_without_attacks_or_vehicles(tmp_path):
    Scene().outcomes.write(tmp_path, "empty", 1, replicates=5)
    (tmp_path / "manifest.json").write_text(json.dumps({"scenarios": [{"scenario": "empty"}]}))
    text = printed(tmp_path)
    assert "False alarms per vehicle-hour: empty, profile dsd (0.00 vehicle-hours" in text
    assert "cusum –" in text
    assert "precision" not in text
    assert "nan" not in text


def test_a_single_run_that_was_not_merged(tmp_path):
    tell().outcomes.write(tmp_path, "lane", 1, replicates=20)
    (tmp_path / "manifest.json").write_text(json.dumps({"scenario": "lane"} | COSTS))
    assert "0.60 0.60–0.60" in printed(tmp_path)
    assert sorted(path.stem for path in tmp_path.glob("*.csv")) == sorted(TABLES)


def test_paper_figures():
    assert TABLE_I["stealth", "isolation_forest"].delay_s == 0.8
    # F1 is the harmonic mean of the two beside it, as far as the rounding to two digits goes.
    for cell in TABLE_I.values():
        mean = 2 * cell.precision * cell.recall / (cell.precision + cell.recall)
        assert cell.f1 == pytest.approx(mean, abs=0.011)
    assert localization_like("sharp_turns", "carla").undefended_m[2] == 4.789
    assert localization_like("slow_curve", "nuscenes").table == "IV (nuScenes)"
    assert localization_like("slow_curve", "carla") is None
    assert localization_like("town", "dsd") is None

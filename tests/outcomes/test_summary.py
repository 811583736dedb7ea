import json
from io import StringIO

import pandas as pd
import pytest
from rich.console import Console

from gpsec.outcomes.merging import merge
from gpsec.outcomes.paper import TABLE_I, localization_like
from gpsec.outcomes.summary import print_summary
from gpsec.outcomes.tables import TABLES, read_table

from .scene import Scene
from .story import tell

DETECTORS = ("chi_square", "cusum", "isolation_forest", "lstm_glr", "told", "never")
DEFENCES = (
    ("never", "none"),
    ("cusum", "ukf"),
    ("isolation_forest", "dead_reckoning"),
    ("isolation_forest", "ukf"),
    ("lstm_glr", "dead_reckoning"),
    ("lstm_glr", "ukf"),
    ("told", "ukf"),
)
COSTS = {
    "sumo_s": 12.5,
    "read_s": 1.5,
    "stages_s": {"truth": 0.5, "detectors": 2.0, "filters": 7.5, "files": 0.25},
    "vehicle_steps": 1_000_000,
    "road_steps": 5_000_000,
    "compile_s": 0.4,
    "peak_vehicles": 512,
}


PAPER = "the paper's figures are for its own data and parameters"


def printed(folder, width=120):
    stream = StringIO()
    print_summary(folder, Console(file=stream, width=width, color_system=None))
    return stream.getvalue()


def flat(text):
    """Return `text` in one line."""
    return " ".join(text.split())


def story(folder, manifest):
    tell().outcomes.write(folder, "lane", 1, replicates=20)
    (folder / "manifest.json").write_text(json.dumps({"scenario": "lane"} | manifest))
    return folder


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Two scenarios with long names and large errors, as a run leaves them."""
    work = tmp_path_factory.mktemp("work")
    for scenario, error_m in (("slow_curve", 1234.5), ("town", 0.0123)):
        plans = ("none", "constant_bias", "stealth", "two_stage")
        scene = Scene(plan_names=plans, detector_names=DETECTORS, defences=DEFENCES, profile_names=("dsd",), capacity=8)
        scene.observe(0, [0, 4])
        for plan in (1, 2, 3):
            scene.fork(0, plan, plan, 1)
            scene.fork(4, 4 + plan, plan, 1)
        scene.alarm[[1, 2, 3, 5, 6, 7], :4] = True
        scene.estimate_m[1:, :, 0] = error_m
        for step in range(1, 101):
            scene.observe(step, range(8))
        for row in range(8):
            scene.close(row, "vw"[row // 4])
        scene.outcomes.write(work / scenario, scenario, 1, replicates=20)
        (work / scenario / "manifest.json").write_text(json.dumps({"scenario": scenario} | COSTS))
    merge(list(work.iterdir()), work / "out")
    return work / "out"


@pytest.fixture(scope="module")
def summary(run):
    return printed(run)


@pytest.mark.parametrize("width", [80, 100, 120, 160])
def test_nothing_is_cut_at_the_width_of_the_console(run, width):
    text = printed(run, width)
    assert max(map(len, text.splitlines())) <= width
    assert "…" not in text
    for name in ("constant_bias", "two_stage", "isolation_forest", "stealth (2)", "1,000,000", "paper, II (DSD)"):
        assert name in text
    assert text.count("1234/.000/1234") + text.count("1235/.000/1235") == 3 * len(DEFENCES)
    assert "told 0.00" in text


def test_tables_take_the_width_that_there_is(run):
    assert [printed(run, width).count("paper, II (DSD)") for width in (80, 160)] == [2, 1]


@pytest.mark.parametrize("width", [80, 100])
def test_a_narrow_terminal_shows_figures_without_intervals_and_the_papers_below(run, width):
    lines = printed(run, width).splitlines()
    row = next(i for i, line in enumerate(lines) if line.startswith("2 events"))
    assert lines[row - 1].split() == ["constant_bias", "chi_square", "1.00", "1.00", "1.00", "0.00"]
    assert lines[row].split() == ["2", "events", "cusum", "1.00", "1.00", "1.00", "0.00"]
    assert lines[row + 1].split() == ["paper", "0.82", "0.95", "0.88", "0.2"]
    assert "intervals, told and never are in detection.csv" in flat(" ".join(lines))
    assert "1.00–1.00" not in " ".join(lines)


def test_a_narrow_terminal_shows_the_slowest_stages_below(run):
    lines = printed(run, 80).splitlines()
    row = next(line for line in lines if line.startswith("slow_curve") and "1,000,000" in line)
    assert row.split() == ["slow_curve", "12.5", "1.5", "10.2", "1,000,000", "512", "2.5", "10.2"]
    assert "  slow_curve: filters 7.5  detectors 2.0  truth 0.5" in lines


def test_long_names_are_folded(tmp_path):
    long = "an_attack_of_many_words_and_fifty_five_letters_in_one_piece"
    Scene(plan_names=("none", long)).outcomes.write(tmp_path, "lane", 1, replicates=5)
    for name in ("detection", "localization", "safety"):
        table = read_table(tmp_path, name)
        figures = [
            column for column in table.columns if column.startswith(("rmse", "precision", "recall", "f1", "delay"))
        ]
        table[figures] = 1.23
        table[[column for column in ("n_events", "n_vehicles") if column in table]] = 7
        table.to_csv(tmp_path / f"{name}.csv", index=False)
    (tmp_path / "manifest.json").write_text(json.dumps({"scenarios": [{"scenario": long} | COSTS]}))
    for width in (80, 120):
        text = printed(tmp_path, width)
        assert max(map(len, text.splitlines())) <= width
        assert "…" not in text
        assert "1,000,000" in text
        assert text.count("1.23/1.23/1.23") == 2 * 2 * 2


def test_paper_rows_stand_beside_ours(summary):
    rows = [line for line in summary.splitlines() if "0.98/1.00/0.99 0.0" in line]
    assert len(rows) == 2
    assert all("lstm_glr" in row and "1.00 1.00–1.00" in row and "0.00 0.00–0.00" in row for row in rows)
    paper = next(line for line in summary.splitlines() if "paper, II (DSD)" in line)
    assert paper.split()[-2:] == ["1.52/1.54/2.16", ".012/.025/.032"]
    assert summary.count("paper, II (DSD)") == 2  # seven defences make two tables; town is not in the paper


def test_captions_say_what_the_papers_rows_are(summary):
    assert flat(summary).count(PAPER) == 3  # Table I with both scenarios, Table II with one
    assert flat(summary).count(f"{PAPER}, and it does not say which attack it is") == 1


@pytest.mark.parametrize("width", [80, 120])
@pytest.mark.parametrize(
    ("manifest", "shown"),
    [
        ({}, True),  # of a former version: by the plan's name
        ({"plans": [{"name": "constant_bias", "attack": "constant_bias", "share": 0.5}]}, True),
        ({"plans": [{"name": "constant_bias", "attack": "noise"}]}, False),
        ({"plans": [{"name": "other", "attack": "constant_bias"}]}, False),
        ({"plans": []}, False),
    ],
)
def test_the_papers_figures_stand_beside_the_attacks_they_are_of(tmp_path, manifest, shown, width):
    text = printed(story(tmp_path, manifest), width)
    figures = "0.82/0.95/0.88 0.2" if width == 120 else "0.82 0.95 0.88 0.2"
    assert (figures in flat(text)) == (PAPER in flat(text)) == shown


def test_the_papers_figures_stand_beside_a_plan_of_another_name(tmp_path):
    scene = Scene(plan_names=("none", "two_lanes"))
    scene.fork(0, 1, 1, 0)
    scene.observe(0, [0, 1])
    scene.close(1, "a")
    scene.outcomes.write(tmp_path, "lane", 1, replicates=5)
    others = {"scenario": "elsewhere", "plans": [{"name": "two_lanes", "attack": "noise"}]}
    ours = {"scenario": "lane", "plans": [{"name": "two_lanes", "attack": "stealth"}]}
    (tmp_path / "manifest.json").write_text(json.dumps({"scenarios": [others, ours]}))
    text = printed(tmp_path)
    assert "0.73/0.85/0.79 0.9" in text
    assert "1 event " in text
    assert "1 events" not in text


def test_an_undefined_interval_is_left_out(tmp_path):
    text = printed(story(tmp_path, {}))
    row = next(line for line in text.splitlines() if "0.82/0.95/0.88" in line)
    # Precision and delay are of one vehicle of the two that were attacked.
    assert row.split()[:3] == ["constant_bias", "cusum", "0.75"]
    assert row.split()[-3:] == ["0.10", "0.82/0.95/0.88", "0.2"]
    assert "nan" not in text


def test_safety_is_of_each_profile_by_itself(tmp_path):
    text = printed(story(tmp_path, {}))
    dsd, carla = (flat(part) for part in text.split("Vehicles that would have touched")[1:])
    assert "lane, profile dsd" in dsd
    assert "none (2)" in dsd
    assert "constant_bias (2)" in dsd
    assert "lane, profile carla" in carla
    assert "none (1)" in carla
    assert "constant_bias" not in carla


def test_errors_and_counts_are_there(summary):
    assert "1234/.000/1234" in summary or "1235/.000/1235" in summary
    assert ".012/.000/.012" in summary
    assert "constant_bias (2)" in summary
    assert "0/0/0/0" in summary


def test_costs_are_for_every_vehicle_step(summary):
    row = next(line for line in summary.splitlines() if "1,000,000" in line)
    assert row.split()[:8] == ["slow_curve", "12.5", "1.5", "10.2", "1,000,000", "512", "2.5", "10.2"]
    assert "filters 7.5, detectors 2.0, truth 0.5" in row
    assert "SUMO's over all vehicles, equipped or not, security's over the equipped ones" in flat(summary)
    assert "compiling" not in summary


def test_costs_of_a_former_manifest_are_for_every_equipped_vehicle_step(tmp_path):
    costs = {key: value for key, value in COSTS.items() if key not in {"road_steps", "compile_s"}}
    text = printed(story(tmp_path, costs))
    row = next(line for line in text.splitlines() if "1,000,000" in line)
    assert row.split()[6:8] == ["12.5", "10.2"]
    assert "SUMO's over the equipped vehicles" in flat(text)


@pytest.mark.parametrize("width", [80, 120])
def test_compiling_is_told_where_it_took_long(tmp_path, width):
    text = printed(story(tmp_path, COSTS | {"compile_s": 41.26}), width)
    assert "compiling kernels, once, is in none of the figures: lane 41.3 s" in flat(text)


@pytest.mark.parametrize("width", [80, 120])
def test_large_counts_take_more_tables_instead_of_being_cut(tmp_path, width):
    story(tmp_path, {})
    safety = read_table(tmp_path, "safety")
    safety = pd.concat([safety.assign(defence=safety["defence"] + str(i)) for i in range(4)])
    safety[["line_touched", "out_of_lane", "wrong_way", "off_road"]] = 123_456
    safety.to_csv(tmp_path / "safety.csv", index=False)
    text = printed(tmp_path, width)
    assert text.count("123456/123456/123456/123456") == 3 * 8
    assert max(map(len, text.splitlines())) <= width


def test_runs_without_attacks_or_vehicles(tmp_path):
    Scene().outcomes.write(tmp_path, "empty", 1, replicates=5)
    (tmp_path / "manifest.json").write_text(json.dumps({"scenarios": [{"scenario": "empty"}]}))
    text = printed(tmp_path)
    assert "False alarms per vehicle-hour: empty, profile dsd (0.00 vehicle-hours" in text
    assert "cusum –" in text
    assert "precision" not in text
    assert "nan" not in text


def test_a_single_run_that_was_not_merged(tmp_path):
    text = printed(story(tmp_path, COSTS))
    assert "0.30 0.00–0.75" in text
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

import json
from math import sqrt

import numpy as np
import pandas as pd
import pytest

from gpsec.core.errors import GpsecError
from gpsec.outcomes import closed_store
from gpsec.outcomes import tables as writing
from gpsec.outcomes.merging import merge
from gpsec.outcomes.tables import TABLES, read_table, whole

from .scene import Scene
from .story import tell


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    folder = tmp_path_factory.mktemp("story")
    tell().outcomes.write(folder, "lane", 7, replicates=200)
    return {name: read_table(folder, name) for name in TABLES}


def one(table, **where):
    for column, value in where.items():
        table = table[table[column] == value]
    assert len(table) == 1
    return table.iloc[0]


def test_detection(tables):
    row = one(tables["detection"], profile="dsd", attack="constant_bias", detector="cusum")
    # a: TP 3 (5, 6, 7), FN 1 (4), FP 1 (2), TN 4, and 8 is the tail; b: FN 6, TN 4.
    assert row["n_events"] == 2
    assert row["precision"] == pytest.approx(3 / 4)
    assert row["recall"] == pytest.approx(3 / 10)
    assert row["f1"] == pytest.approx(2 * 0.75 * 0.3 / 1.05)
    assert row["false_positive_rate"] == pytest.approx(1 / 9)
    # The alarm of a ends in step 9, the attack in step 8.
    assert row["alarm_ends_after_mean_s"] == pytest.approx(0.1)
    # The twin of a is in alarm in step 2, which is before. Undefended, a touches the line in step 4, and is seen in 5.
    assert row["detected_not_twin_share"] == 0.5
    assert (row["n_line_events"], row["seen_before_line_share"]) == (1, 0.0)
    assert [row["delay_mean_s"], row["delay_median_s"], row["delay_p95_s"]] == pytest.approx([0.1] * 3)
    assert row["detected_share"] == 0.5
    # One false alarm in 2 vehicles · 1 s.
    assert row["false_alarms_per_vehicle_hour"] == pytest.approx(1800.0)
    assert row["vehicle_hours"] == pytest.approx(2 / 3600)
    # Statistic 2 in alarm, else 1. Positives: 3 and 7. Negatives: 9 like the benign ones (1 of 20): 0.45, 8.55.
    assert row["roc_auc"] == pytest.approx((3 * (8.55 + 0.225) + 7 * 4.275) / 90)
    assert row["pr_auc"] == pytest.approx(0.3 * 3 / 3.45 + 0.7 * 10 / 19)
    # At 0.1 an hour, two seconds of benign driving tell nothing of a threshold.
    assert np.isnan(row["matched_threshold"])
    assert row["threshold"] == 1.0
    # Resampled fleets hold a twice, a and b, or b twice; b alone has neither precision nor delay, so that these are
    # of one vehicle.
    assert (row["recall_lo"], row["recall_hi"]) == (0.0, 0.75)
    assert row[["precision_lo", "precision_hi", "delay_mean_s_lo", "delay_mean_s_hi"]].isna().all()


def test_detection_without_an_attack(tables):
    row = one(tables["detection"], profile="dsd", attack="none", detector="cusum")
    assert row["n_events"] == 0
    assert row["false_positive_rate"] == pytest.approx(1 / 20)
    name = "false_alarms_per_vehicle_hour"
    assert list(row[[name, f"{name}_lo", f"{name}_hi"]]) == pytest.approx([1800.0, 0.0, 3600.0])
    empty = ["precision", "recall", "f1", "delay_mean_s", "delay_p95_s", "detected_share", "roc_auc", "pr_auc"]
    assert row[empty].isna().all()


def test_detection_of_a_detector_that_is_never_in_alarm(tables):
    row = one(tables["detection"], profile="dsd", attack="constant_bias", detector="never")
    assert np.isnan(row["precision"])
    assert (row["recall"], row["f1"], row["detected_share"], row["roc_auc"]) == (0.0, 0.0, 0.0, 0.5)
    assert row[["delay_mean_s", "delay_mean_s_lo", "delay_median_s"]].isna().all()
    # Wilson's interval for 0 of 2: 3.8415 / 5.8415.
    assert row["detected_share_hi"] == pytest.approx(3.8415 / 5.8415, abs=1e-4)


@pytest.mark.parametrize(("profile", "hours"), [("dsd", 2 / 3600), ("carla", 0.5 / 3600)])
def test_no_false_alarm_does_not_mean_that_there_never_is_one(tables, profile, hours):
    row = one(tables["detection"], profile=profile, attack="none", detector="never")
    name = "false_alarms_per_vehicle_hour"
    assert (row[name], row[f"{name}_lo"]) == (0.0, 0.0)
    assert row[f"{name}_hi"] == pytest.approx(np.log(40.0) / hours)


def single(folder, *, alarms, scored=True, plans=("none", "jamming")):
    """One vehicle, attacked from its fifth step of ten; `alarms` of CUSUM without and with the attack."""
    scene = Scene(plan_names=plans)
    for step in range(10):
        if step == 4:
            scene.fork(0, 1, 1, step)
        scene.alarm[:2, 0] = [said[step] == "A" for said in alarms]
        scene.scored[1] = scored or step < 4
        scene.observe(step, [0, 1] if step >= 4 else [0])
    scene.close(0, "a")
    scene.close(1, "a")
    scene.outcomes.write(folder, "lane", 1, replicates=20, confidence=0.9)
    return folder


def test_one_vehicle_has_figures_but_no_bootstrap_interval(tmp_path):
    single(tmp_path, alarms=("-A--------", "-A---AAAAA"))
    detection, localization = read_table(tmp_path, "detection"), read_table(tmp_path, "localization")
    row = one(detection, profile="dsd", attack="jamming", detector="cusum")
    names = ["precision", "recall", "f1", "delay_mean_s", "false_alarms_per_vehicle_hour"]
    assert row[names].notna().all()
    assert row[[f"{name}{side}" for name in names for side in ("_lo", "_hi")]].isna().all()
    assert row[["detected_share_lo", "detected_share_hi"]].notna().all()
    row = one(localization, profile="dsd", attack="jamming", defence="cusum+ukf")
    assert row["rmse_xy_m"] == 0.0
    assert row[[name for name in row.index if name.endswith(("_lo", "_hi"))]].isna().all()


def test_the_bound_of_no_false_alarm_is_at_the_confidence_of_the_run(tmp_path):
    single(tmp_path, alarms=("----------", "-----A----"))
    row = one(read_table(tmp_path, "detection"), profile="dsd", attack="jamming", detector="cusum")
    assert row["false_alarms_per_vehicle_hour_lo"] == 0.0
    assert row["false_alarms_per_vehicle_hour_hi"] == pytest.approx(np.log(20.0) * 3600.0)


def test_where_no_attacked_sample_was_scored_precision_and_recall_are_undefined(tmp_path):
    single(tmp_path, alarms=("-A--------", "-AAAAAAAAA"), scored=False)
    row = one(read_table(tmp_path, "detection"), profile="dsd", attack="jamming", detector="cusum")
    assert (row["n_events"], row["detected_share"], row["false_positive_rate"]) == (1, 1.0, 0.25)
    undefined = ["roc_auc", "pr_auc"]
    undefined += [f"{name}{part}" for name in ("precision", "recall", "f1") for part in ("", "_lo", "_hi")]
    assert row[undefined].isna().all()


def test_profiles_are_apart(tables):
    row = one(tables["detection"], profile="carla", attack="none", detector="cusum")
    assert row["threshold"] == 3.0
    assert row["vehicle_hours"] == pytest.approx(0.5 / 3600)
    assert row["false_alarms_per_vehicle_hour"] == 0.0
    nobody = one(tables["detection"], profile="carla", attack="constant_bias", detector="cusum")
    assert nobody["n_events"] == 0
    assert nobody[["precision", "recall", "f1", "roc_auc", "detected_share_hi"]].isna().all()


def test_localization(tables):
    # Ten steps under attack: a has four, in two of which it is 1 m off under cusum+ukf, b six without error.
    row = one(tables["localization"], profile="dsd", attack="constant_bias", defence="cusum+ukf")
    assert (row["n_events"], row["n_vehicles"]) == (2, 2)
    assert row["rmse_x_m"] == 0.0
    assert row["rmse_y_m"] == row["rmse_xy_m"] == row["rmse_cross_track_m"] == pytest.approx(sqrt(0.2))
    assert row["max_cross_track_m"] == 1.0
    assert (row["rmse_y_m_lo"], row["rmse_y_m_hi"]) == pytest.approx((0.0, sqrt(0.5)))
    row = one(tables["localization"], profile="dsd", attack="constant_bias", defence="never+none")
    found = row[["rmse_x_m", "rmse_y_m", "rmse_xy_m", "rmse_cross_track_m", "rmse_along_track_m"]]
    assert list(found) == pytest.approx([sqrt(6.4), sqrt(3.6), sqrt(10), sqrt(3.6), sqrt(6.4)])
    assert row["max_cross_track_m"] == 3.0
    # a is 5 m off in each of its steps, 4 m to the east and 3 m to the north; b nowhere.
    assert list(row[["average_max_x_m", "average_max_y_m", "average_max_xy_m"]]) == [2.0, 1.5, 2.5]
    benign = one(tables["localization"], profile="dsd", attack="none", defence="never+none")
    assert (benign["n_events"], benign["n_vehicles"], benign["rmse_xy_m"]) == (0, 2, 0.0)
    assert benign[["average_max_x_m", "average_max_xy_m"]].isna().all()
    nobody = one(tables["localization"], profile="carla", attack="constant_bias", defence="never+none")
    assert nobody[["rmse_xy_m", "rmse_xy_m_lo", "max_cross_track_m"]].isna().all()


def test_safety(tables):
    columns = ["n_vehicles", "line_touched", "out_of_lane", "wrong_way", "off_road"]
    table = tables["safety"]
    assert list(table.columns[:4]) == ["scenario", "profile", "attack", "defence"]
    attacked = {"profile": "dsd", "attack": "constant_bias"}
    assert list(one(table, **attacked, defence="cusum+ukf")[columns]) == [2, 1, 0, 0, 0]
    assert list(one(table, **attacked, defence="never+none")[columns]) == [2, 1, 1, 0, 1]
    assert one(table, **attacked, defence="never+none")["off_road_share"] == 0.5
    # c is of another profile, and never attacked.
    for profile, vehicles in (("dsd", 2), ("carla", 1)):
        row = one(table, profile=profile, attack="none", defence="never+none")
        assert list(row[columns]) == [vehicles, 0, 0, 0, 0]
    nobody = one(table, profile="carla", attack="constant_bias", defence="never+none")
    assert nobody["n_vehicles"] == 0
    assert nobody[["off_road_share", "off_road_share_lo", "off_road_share_hi"]].isna().all()


def test_events(tables):
    assert list(zip(tables["events"]["vehicle_id"], tables["events"]["defence"], strict=True)) == [
        ("a", "cusum+ukf"),
        ("a", "never+none"),
        ("b", "cusum+ukf"),
        ("b", "never+none"),
    ]
    row = one(tables["events"], vehicle_id="a", defence="cusum+ukf")
    assert (row["scenario"], row["seed"], row["profile"], row["attack"]) == ("lane", 7, "dsd", "constant_bias")
    assert (row["detector"], row["response"], row["vehicle_type"]) == ("cusum", "ukf", "car")
    assert (row["start_s"], row["end_s"], row["cut_short"]) == (0.5, 0.9, False)
    assert (row["detected"], row["in_alarm_at_start"]) == (True, False)
    assert row["detection_delay_s"] == pytest.approx(0.1)
    assert row["deviation_at_detection_m"] == 1.0
    assert row["isolated_share"] == 0.75
    assert row["time_to_retrust_s"] == pytest.approx(0.1)  # step 9, one after the end in step 8
    assert (row["rmse_cross_track_m"], row["max_cross_track_m"]) == (pytest.approx(sqrt(0.5)), 1.0)
    assert (row["outcome"], row["time_to_outcome_s"]) == ("line_touched", pytest.approx(0.1))
    # Nothing is undetected in the first step of the attack, and in the second there is the alarm.
    assert row["max_undetected_deviation_m"] == 0.0
    assert np.isnan(row["max_undetected_deviation_s"])
    assert not row["line_touched_unseen"]
    row = one(tables["events"], vehicle_id="a", defence="never+none")
    assert row["max_undetected_deviation_m"] == 1.0
    assert row["max_undetected_deviation_s"] == pytest.approx(0.1)
    assert (row["line_touched_unseen"], row["out_of_lane_unseen"]) == (True, False)
    assert (row["rmse_x_m"], row["rmse_y_m"], row["rmse_xy_m"]) == (4.0, 3.0, 5.0)
    assert (row["max_x_m"], row["max_y_m"], row["max_xy_m"]) == (4.0, 3.0, 5.0)
    assert (row["outcome"], row["time_to_outcome_s"]) == ("off_road", 0.0)
    assert not row["detected"]
    empty = ["detection_delay_s", "deviation_at_detection_m", "time_to_retrust_s"]
    assert row[empty].isna().all()
    row = one(tables["events"], vehicle_id="b", defence="cusum+ukf")
    assert (row["start_s"], row["end_s"], row["cut_short"], row["outcome"]) == (0.5, 1.1, True, "none")
    assert row[["detection_delay_s", "time_to_outcome_s"]].isna().all()


def test_samples_of_events_add_up_to_the_figures_of_the_detector(tables):
    events = tables["events"]
    events = events[(events["profile"] == "dsd") & (events["defence"] == "cusum+ukf")]
    hits, alarms, missed = (events[name].sum() for name in ("true_positives", "false_positives", "false_negatives"))
    assert 0 < hits < hits + missed
    row = one(tables["detection"], profile="dsd", attack="constant_bias", detector="cusum")
    assert row["precision"] == pytest.approx(hits / (hits + alarms))
    assert row["recall"] == pytest.approx(hits / (hits + missed))
    assert events["true_negatives"].sum() > 0
    seconds, squared = events["attack_seconds"], events["rmse_xy_m"] ** 2
    row = one(tables["localization"], profile="dsd", attack="constant_bias", defence="cusum+ukf")
    assert row["rmse_xy_m"] == pytest.approx(sqrt((squared * seconds).sum() / seconds.sum()))


def test_vehicles(tables):
    table = tables["vehicles"]
    assert len(table) == 5 * 2
    row = one(table, vehicle_id="a", attack="none", defence="cusum+ukf")
    assert (row["alarms"], row["false_alarms"], row["outcome"]) == (1, 1, "none")
    assert (row["vehicle_seconds"], row["scored_seconds"]) == (1.0, 1.0)
    assert np.isnan(row["arrive_s"])
    row = one(table, vehicle_id="a", attack="constant_bias", defence="cusum+ukf")
    assert (row["alarms"], row["false_alarms"], row["outcome"]) == (2, 1, "line_touched")
    assert row["rmse_xy_m"] == pytest.approx(sqrt(0.2))
    row = one(table, vehicle_id="c", attack="none", defence="never+none")
    assert (row["profile"], row["depart_s"], row["arrive_s"]) == ("carla", 0.1, 0.6)
    assert row["vehicle_seconds"] == 0.5


def test_files_are_the_same_bytes_whatever_the_order_in_which_tracks_were_closed(tmp_path, monkeypatch):
    first = tell()
    monkeypatch.setattr(closed_store, "_PACKED_AT_ONCE", 2)
    closed = []
    with monkeypatch.context() as patch:
        patch.setattr(closed_store.ClosedStore, "add", lambda store, tracks: closed.append(tracks))
        second = tell()
    assert len(closed) > 2
    for tracks in reversed(closed):
        second.outcomes._closed.add(tracks)
    assert len(second.outcomes._closed._packed) > 1
    for scene, name in ((first, "first"), (second, "second")):
        scene.outcomes.write(tmp_path / name, "lane", 7, replicates=50)
    for name in TABLES:
        files = [(tmp_path / folder / f"{name}.csv").read_bytes() for folder in ("first", "second")]
        assert files[0] == files[1]
        assert b"nan" not in files[0].lower()
        assert b"\r" not in files[0]
    assert sorted(path.name for path in (tmp_path / "first").iterdir()) == sorted(f"{n}.csv" for n in TABLES)


def test_a_run_without_vehicles_writes_headers_and_empty_cells(tmp_path):
    Scene().outcomes.write(tmp_path, "empty", 1, replicates=20)
    counts = {name: len(read_table(tmp_path, name)) for name in TABLES}
    filled = {"detection": 8, "localization": 8, "safety": 8}
    assert counts == dict.fromkeys(TABLES, 0) | filled
    detection = read_table(tmp_path, "detection")
    known = detection.drop(columns=["scenario", "profile", "attack", "detector", "n_events"])
    assert (
        known.drop(columns=["vehicle_hours", "threshold", "threshold_from", "rate", "n_line_events"])
        .isna()
        .all(axis=None)
    )
    assert (read_table(tmp_path, "safety")["line_touched_share"].isna()).all()


def test_a_vehicle_that_never_settled_is_listed_but_counts_nowhere(tmp_path):
    scene = Scene()
    scene.tracks.settled[:] = False
    scene.estimate_m[:] = 50.0
    scene.alarm[:] = True
    scene.observe(0, [0])
    scene.close(0, "brief", arrive_s=0.2)
    scene.outcomes.write(tmp_path, "lane", 1, replicates=20)
    row = one(read_table(tmp_path, "vehicles"), defence="cusum+ukf")
    assert (row["vehicle_seconds"], row["alarms"], row["outcome"]) == (0.0, 0, "none")
    assert np.isnan(row["rmse_xy_m"])
    assert (read_table(tmp_path, "safety")["n_vehicles"] == 0).all()


def test_a_plan_gives_the_same_rows_alone_and_among_others(tmp_path):
    def run(plans, plan, folder):
        scene = Scene(plan_names=plans)
        for step in range(6):
            if step == 2:
                scene.fork(0, 2, plan, step)
                scene.fork(1, 3, plan, step)
            scene.estimate_m[:, 0, 1] = [0.1, 0.2, 1.0 + step, 0.3]
            scene.alarm[2:, 0] = step > 3, step > 4
            scene.observe(step, [0, 1, 2, 3] if step >= 2 else [0, 1])
        for row, name in enumerate("abab"):
            scene.close(row, name)
        scene.outcomes.write(tmp_path / folder, "lane", 3, replicates=100)

    run(("none", "drift"), 1, "alone")
    run(("none", "replay", "drift"), 2, "among")
    for name in TABLES:
        alone, among = (
            [line for line in (tmp_path / folder / f"{name}.csv").read_text().splitlines() if "replay" not in line]
            for folder in ("alone", "among")
        )
        assert alone == among


def finished_run(folder, scenario, seed=1):
    tell().outcomes.write(folder, scenario, seed, replicates=20)
    (folder / "manifest.json").write_text(json.dumps({"scenario": scenario}))


def test_merge_joins_tables_and_manifests(tmp_path):
    folders = [tmp_path / "work" / name for name in ("town", "highway")]
    for folder in folders:
        finished_run(folder, folder.name)
        (folder / "steps.parquet").write_bytes(folder.name.encode())
    merge(folders, tmp_path / "out")
    for name in TABLES:
        parts = pd.concat([read_table(folder, name) for folder in reversed(folders)], ignore_index=True)
        pd.testing.assert_frame_equal(read_table(tmp_path / "out", name), parts)
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert manifest["scenarios"] == [{"scenario": "highway"}, {"scenario": "town"}]
    assert (tmp_path / "out" / "steps-town.parquet").read_bytes() == b"town"


def test_merge_of_one_run_keeps_its_bytes(tmp_path):
    finished_run(tmp_path / "lane", "lane")
    (tmp_path / "lane" / "steps.parquet").write_bytes(b"log")
    merge([tmp_path / "lane"], tmp_path / "out")
    for name in [*(f"{table}.csv" for table in TABLES), "steps.parquet"]:
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "lane" / name).read_bytes()


def test_merge_says_which_file_is_wrong(tmp_path):
    finished_run(tmp_path / "a", "a")
    finished_run(tmp_path / "b", "b")
    (tmp_path / "b" / "safety.csv").write_text("scenario,attack\n")
    with pytest.raises(GpsecError, match=r"b/safety\.csv: header expected 'scenario,profile,attack,defence.*found"):
        merge([tmp_path / "a", tmp_path / "b"], tmp_path / "out")
    assert not (tmp_path / "out" / "safety.csv").exists()
    (tmp_path / "b" / "safety.csv").unlink()
    with pytest.raises(GpsecError, match=r"b/safety\.csv: expected a file of a finished run"):
        merge([tmp_path / "a", tmp_path / "b"], tmp_path / "out")


def test_a_file_that_fails_half_way_leaves_the_former_one(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("former")

    def fail():
        with whole(path) as partial:
            partial.write_text("half")
            raise ValueError("full disk")

    with pytest.raises(ValueError, match="full disk"):
        fail()
    assert path.read_text() == "former"
    assert list(tmp_path.iterdir()) == [path]


def test_a_scored_sample_stands_for_a_tenth_of_a_second_at_a_short_step(tmp_path):
    scene = Scene(capacity=1, step_s=0.01)
    for step in range(100):
        scene.scored[:] = step % 10 == 9
        scene.observe(step, [0])
    scene.close(0, "a")
    scene.outcomes.write(tmp_path, "lane", 1, replicates=2)
    table = read_table(tmp_path, "vehicles")
    assert table[["vehicle_seconds", "scored_seconds"]].to_numpy() == pytest.approx(1.0)


def caused(folder, *, honest_m):
    """Ten vehicles, one of them attacked; it is 1 m off, all others `honest_m`: over 0.85 m they touch a line."""
    scene = Scene(capacity=11)
    for step in range(4):
        if step == 2:
            scene.fork(0, 10, 1, step)
        scene.estimate_m[:, :, 1] = honest_m
        scene.estimate_m[10, :, 1] = 1.0
        scene.isolated[0, 0] = step < 2
        scene.alarm[0, 0] = step == 3
        scene.alarm[10, 0] = True
        scene.observe(step, list(range(10)) + [10] * (step >= 2))
    for row in range(10):
        scene.close(row, f"v{row}")
    scene.close(10, "v0")
    scene.outcomes.write(folder, "lane", 1, replicates=20)
    return folder


def test_what_an_attack_caused_is_what_its_twin_has_not(tmp_path):
    folder = caused(tmp_path, honest_m=0.5)
    row = one(read_table(folder, "safety"), profile="dsd", attack="constant_bias", defence="cusum+ukf")
    assert (row["line_touched"], row["line_touched_caused_share"], row["out_of_lane_caused_share"]) == (1, 1.0, 0.0)
    # Two steps of forty without GNSS: 3 minutes in an hour.
    assert row["isolated_minutes_per_vehicle_hour"] == pytest.approx(3.0)
    detection = one(read_table(folder, "detection"), profile="dsd", attack="constant_bias", detector="cusum")
    assert (detection["detected_share"], detection["detected_not_twin_share"]) == (1.0, 0.0)
    localization = one(read_table(folder, "localization"), profile="dsd", attack="constant_bias", defence="cusum+ukf")
    assert (localization["rmse_xy_m"], localization["twin_rmse_xy_m"]) == (1.0, 0.5)
    event = one(read_table(folder, "events"), defence="cusum+ukf")
    assert (event["outcome"], event["twin_outcome"], event["time_to_line_s"]) == ("line_touched", "none", 0.0)


def test_outcomes_are_left_out_where_honest_vehicles_touch_a_line(tmp_path):
    safety = read_table(caused(tmp_path, honest_m=0.9), "safety")
    mine = safety[safety["profile"] == "dsd"]
    assert mine[["line_touched", "out_of_lane_share", "line_touched_caused_share"]].isna().all(axis=None)
    assert mine["note"].str.startswith("100% of the honest undefended vehicles touch a line").all()
    assert mine["isolated_minutes_per_vehicle_hour"].notna().all()


def test_a_table_is_the_same_bytes_however_many_rows_are_written_at_once(tmp_path, monkeypatch):
    table = pd.DataFrame({"name": ["a", None, "c"], "value": [1.25, np.nan, 1e-7], "count": [1, 2, 3]})
    for rows in (1, 2, 3):
        monkeypatch.setattr(writing, "_ROWS_AT_ONCE", rows)
        writing.write_frame(table, tmp_path / f"{rows}.csv")
    assert (tmp_path / "3.csv").read_bytes() == b"name,value,count\na,1.25,1\n,,2\nc,1e-07,3\n"
    assert len({(tmp_path / f"{rows}.csv").read_bytes() for rows in (1, 2, 3)}) == 1
    writing.write_frame(table[:0], tmp_path / "empty.csv")
    assert (tmp_path / "empty.csv").read_bytes() == b"name,value,count\n"

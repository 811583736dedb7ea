import pandas as pd

from gpsec.paper import contexts


def test_steps_belong_to_junctions_lane_changes_and_roads(tmp_path):
    # One step a second: the road, a change from lane 0 to lane 1 at 4 s, a junction from 8 s on.
    lanes = ["e_0"] * 4 + ["e_1"] * 4 + [":j_0_0"] * 2
    log = pd.DataFrame(
        {
            "time_s": [float(k) for k in range(10)],
            "vehicle_id": "v",
            "plan": "a",
            "lane": lanes,
            "attacked": [False] + [True] * 9,
            "lstm_glr_alarm": [True, False, False, True, True, True, True, True, True, False],
            "told_alarm": True,
        }
    )
    other = log.assign(plan="none", lstm_glr_alarm=False)
    pd.concat([log, other]).to_parquet(tmp_path / "steps.parquet")
    found = contexts.recall_by_context(tmp_path, "a")
    assert list(found) == ["lstm_glr"]
    shares = {name: (each.value, each.n) for name, each in found["lstm_glr"].items()}
    # Road: 1 s (no) and 7 s (yes); the change: 2-6 s, all but the first; the junction: 8 s (yes) and 9 s (no).
    assert shares == {"road": (0.5, 1), "lane change": (0.8, 1), "junction": (0.5, 1)}


def test_a_new_edge_is_no_lane_change(tmp_path):
    log = pd.DataFrame(
        {
            "time_s": [0.0, 1.0, 0.0],
            "vehicle_id": ["v", "v", "w"],
            "plan": "a",
            "lane": ["e_0", "f_1", "f_0"],
            "attacked": True,
            "lstm_glr_alarm": True,
        }
    )
    log.to_parquet(tmp_path / "steps.parquet")
    found = contexts.recall_by_context(tmp_path, "a")["lstm_glr"]
    assert (found["road"].n, found["lane change"].n) == (2, 0)

"""The loop as a whole, on recorded traffic of the town: what a run's files must not depend on."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gpsec.core.errors import GpsecError
from gpsec.core.threads import Threads
from gpsec.outcomes import tables as tables_of_a_run
from gpsec.pipeline import run as loop
from gpsec.scenario import Scenario
from gpsec.traffic.recording import Recording, record_traffic
from gpsec.traffic.source import Frame

from .conftest import PLANS, WHEN, Traffic, with_plans

TABLES = tuple(f"{name}.csv" for name in tables_of_a_run.TABLES)
NO_EFFECT = {"attack": "constant_bias", "bias_m": 1e-200, **WHEN}


def tables(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in TABLES}


def read(folder: Path, name: str) -> pd.DataFrame:
    """Every cell as the file has it."""
    return pd.read_csv(folder / f"{name}.csv", keep_default_na=False, dtype=str)


def rows_of(folder: Path, *attacks: str) -> dict[str, str]:
    """The rows of every table that belong to these attacks."""
    frames = {name: read(folder, Path(name).stem) for name in TABLES}
    return {name: frame[frame["attack"].isin(attacks)].to_csv(index=False) for name, frame in frames.items()}


@pytest.fixture(scope="module")
def baseline(town: Scenario, traffic: Traffic, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with SUMO itself; every other run in this file replays its traffic."""
    folder = tmp_path_factory.mktemp("baseline")
    loop.run_scenario(town, folder, lambda progress: None)
    return folder


@pytest.fixture(scope="module")
def steps(town: Scenario, traffic: Traffic, tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    """Every step of a run with a plan that attacks without any effect, and a real one."""
    plans = {"no_effect": NO_EFFECT, "constant_bias": PLANS["constant_bias"]}
    raw = with_plans(town, plans).model_dump(mode="json") | {"log_steps": True, "duration_s": 30.0}
    folder = tmp_path_factory.mktemp("steps")
    loop.run_scenario(Scenario.model_validate(raw), folder, lambda progress: None)
    return pd.read_parquet(folder / "steps.parquet")


def test_the_run_is_worth_the_comparison(baseline):
    manifest = json.loads((baseline / "manifest.json").read_text())
    assert manifest["vehicles"] > 20
    events = read(baseline, "events")
    assert set(PLANS) <= set(events["attack"])
    assert (events["attack"].value_counts() > 30).all()
    assert set(events["detected"]) == {"True", "False"}


def test_same_seed_same_bytes_and_a_recording_stands_for_sumo(baseline, town, traffic, replay, go):
    replay(traffic)
    assert tables(go(town)) == tables(baseline)


def test_another_seed_gives_other_noise(baseline, town, traffic, replay, go):
    replay(traffic)
    other = tables(go(town.model_copy(update={"seed": town.seed + 1})))
    assert all(other[name] != table for name, table in tables(baseline).items())


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_do_not_matter(baseline, town, traffic, replay, go, monkeypatch, threads):
    monkeypatch.setattr(Threads, "MIN_ROWS", 1)
    replay(traffic)
    assert tables(go(town.model_copy(update={"threads": threads}))) == tables(baseline)


@pytest.mark.parametrize("plan", ["constant_bias", "jamming"])
def test_a_plan_alone_is_as_it_is_among_others(baseline, town, traffic, replay, go, plan):
    replay(replace(traffic, zones=[]))
    alone = go(with_plans(town, {plan: PLANS[plan]}))
    assert rows_of(alone, "none", plan) == rows_of(baseline, "none", plan)


def test_a_defence_alone_is_as_it_is_among_others(baseline, town, traffic, replay, go):
    replay(traffic)
    raw = town.model_dump(mode="json") | {"defences": [{"detector": "told", "response": "ukf"}]}
    few, all_ = read(go(Scenario.model_validate(raw)), "localization"), read(baseline, "localization")
    kept = all_[all_["defence"].isin(["never+none", "told+ukf"])].reset_index(drop=True)
    pd.testing.assert_frame_equal(few, kept)


def renumbered(recording: Recording) -> Recording:
    """The same traffic, whose vehicles own other rows, so that they come in another order in every step."""
    count = int(recording.rows.max()) + 1
    number = np.random.default_rng(9).permutation(count).astype(np.int32)

    class Renumbered:
        step_s = float(recording.step_s[0])
        sumo_s = read_s = 0.0

        def frames(self, duration_s: float | None = None):
            for at in range(len(recording)):
                yield self._renumber(recording.frame(at))

        def _renumber(self, frame: Frame) -> Frame:
            rows = number[frame.rows]
            order = np.argsort(rows)
            departures = [replace(departure, row=int(number[departure.row])) for departure in frame.departures]
            return replace(
                frame,
                left=[int(number[row]) for row in frame.left],
                departures=departures[::-1],
                rows=rows[order],
                front_m=frame.front_m[order],
                lane=frame.lane[order],
            )

        def close(self) -> None:
            """Nothing to do."""

    return record_traffic(Renumbered(), None)


def test_the_order_of_rows_does_not_matter(baseline, town, traffic, replay, go):
    replay(replace(traffic, recording=renumbered(traffic.recording)))
    assert tables(go(town)) == tables(baseline)


def test_an_attack_without_effect_leaves_its_track_equal_to_its_benign_twin(steps):
    """From the fork on, to the last bit, in everything that is not told the truth."""
    key = ["vehicle_id", "time_s"]
    attacked = steps[steps["plan"] == "no_effect"].set_index(key)
    benign = steps[steps["plan"] == "none"].set_index(key).loc[attacked.index]
    assert attacked["attacked"].sum() > 300
    assert (~attacked["attacked"]).sum() > 300
    told = [name for name in steps.columns if name.startswith("told")]
    ignored = ["plan", "attacked", *told]
    pd.testing.assert_frame_equal(attacked.drop(columns=ignored), benign.drop(columns=ignored), check_exact=True)
    assert not attacked[told].equals(benign[told])


def test_a_track_begins_with_its_attack_and_goes_on_to_the_end_of_the_journey(steps):
    for _, track in steps[steps["plan"] == "constant_bias"].groupby("vehicle_id"):
        attacked = track["attacked"].to_numpy()
        assert attacked[0]
        assert (np.diff(attacked.astype(int)) <= 0).all()  # once over, it does not begin again
    last = steps.pivot_table("time_s", index="vehicle_id", columns="plan", aggfunc="max")
    ended = last.dropna(subset=["constant_bias"])
    assert (ended["constant_bias"] == ended["none"]).all()


def test_the_fix_is_displaced_only_while_attacked(steps):
    key = ["vehicle_id", "time_s"]
    track = steps[steps["plan"] == "constant_bias"].set_index(key).dropna(subset=["fix_x_m"])
    honest = steps[steps["plan"] == "none"].set_index(key).loc[track.index]
    moved = np.hypot(track["fix_x_m"] - honest["fix_x_m"], track["fix_y_m"] - honest["fix_y_m"])
    assert moved[track["attacked"]].to_numpy() == pytest.approx(2.4)
    assert (moved[~track["attacked"]] == 0.0).all()


def test_never_and_none_never_isolate_and_the_told_does_exactly_from_the_start(steps):
    assert not steps["never+none_isolated"].any()
    attacked = steps[steps["attacked"]]
    assert attacked["told+ukf_isolated"].all()
    assert attacked["told_alarm"].all()
    assert not steps.loc[~steps["attacked"], "told_alarm"].any()


def test_a_large_bias_is_detected_without_delay_and_shows_up_in_the_undefended_estimate(town, traffic, replay, go):
    replay(replace(traffic, zones=[]))
    whole = {**PLANS["constant_bias"], "direction_deg": 90.0, "side": "as_given", "bias_m": 6.0}
    raw = with_plans(town, {"bias": whole}).model_dump(mode="json")
    raw["fleet"]["profile"] = {"dsd": 1.0}
    raw["detection"]["detectors"] = ["chi_square"]
    raw["defences"] = [{"detector": "chi_square", "response": "ukf"}]
    events = read(go(Scenario.model_validate(raw)), "events")
    events = events[(events["detector"] == "chi_square") & (events["attack"] == "bias")]
    detected = events[events["detected"] == "True"]
    assert len(detected) >= 10
    # A residual of more than 60 standard deviations, seen at once unless the camera sees no lane just then.
    assert detected["detection_delay_s"].astype(float).median() == 0.0


def test_undefended_error_is_the_bias_and_mitigation_takes_it_away(baseline):
    table = read(baseline, "localization").set_index(["profile", "attack", "defence"])["rmse_cross_track_m"]
    undefended, defended = (float(table["carla", "constant_bias", name]) for name in ("never+none", "told+ukf"))
    # The filter takes some steps to follow the bias of 2.4 m.
    assert 1.5 < undefended < 2.4
    assert defended < 0.3


def test_manifest(baseline, town):
    manifest = json.loads((baseline / "manifest.json").read_text())
    expected = {"configuration", "seed", "versions", "git_commit", "vehicle_steps", "peak_vehicles", "sumo_s", "read_s"}
    assert expected <= set(manifest)
    assert {"truth", "sensors", "attacks", "matching", "EKF", "UKF", "outcomes"} <= set(manifest["stages_s"])
    assert {"libsumo", "numpy", "numba"} <= set(manifest["versions"])
    assert manifest["steps"] == round(town.duration_s / manifest["step_s"])
    assert 0 < manifest["peak_vehicles"] <= manifest["peak_on_road"]
    assert manifest["peak_vehicles"] <= manifest["vehicles"]
    assert manifest["vehicle_steps"] <= manifest["track_steps"]
    assert Scenario.model_validate(manifest["configuration"]) == town


class Nobody:
    step_s = 0.1
    sumo_s = read_s = 0.0

    def __init__(self, on_road: int) -> None:
        self.on_road = on_road

    def frames(self, duration_s: float | None = None):
        none = np.zeros(0, np.int32)
        for step in range(20):
            yield Frame(step, 0.1 * step, [], [], none, np.zeros((0, 2)), none, self.on_road)

    def close(self) -> None:
        """Nothing to do."""


@pytest.mark.parametrize(("on_road", "sentence"), [(0, "no vehicle departs"), (7, "no vehicle is equipped")])
def test_a_run_without_a_fleet_is_refused(town, replay, go, on_road, sentence):
    replay(Traffic(record_traffic(Nobody(on_road), None), []))
    with pytest.raises(GpsecError, match=rf"town\.sumocfg: {sentence}"):
        go(town)


def test_progress_reaches_the_end(town, traffic, replay, tmp_path):
    replay(traffic)
    seen: list = []
    report: Callable = seen.append
    loop.run_scenario(town, tmp_path, report)
    driving = [progress for progress in seen if progress.vehicles]
    assert driving[-1].time_s == pytest.approx(town.duration_s, abs=1.0)
    assert [p.time_s for p in driving] == sorted(p.time_s for p in driving)


def test_what_sumo_warns_of_in_its_input_is_said_and_kept(town, traffic, replay, tmp_path, monkeypatch):
    replay(traffic)
    monkeypatch.setattr(loop.RemoteSession, "warnings", ["Warning: Invalid characters for Poly ID 'old town'"])
    told = []
    loop.run_scenario(
        town.model_copy(update={"duration_s": 10.0}), tmp_path, lambda progress: told.append(progress.note)
    )
    note = "SUMO warns: Invalid characters for Poly ID 'old town'"
    assert note in told
    assert note in json.loads((tmp_path / "manifest.json").read_text())["notes"]

"""Vehicles that overtake on the oncoming lane of a road whose ends turn round into each other."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gpsec.scenario import load_scenario
from gpsec.scenario.overrides import parse_set

NODES = 'id="a" x="0" y="0"\nid="b" x="2000" y="0"'
EDGES = 'id="ab" from="a" to="b" speed="25"\nid="ba" from="b" to="a" speed="25"'
ROUTES = (
    '<routes><vType id="slow" maxSpeed="6"/><vType id="fast" maxSpeed="25" lcOpposite="5"/>'
    '<flow id="s" type="slow" from="ab" to="ab" begin="0" period="12" number="4" departSpeed="max"/>'
    '<flow id="q" type="fast" from="ab" to="ab" begin="6" period="14" number="4" departSpeed="max"/></routes>'
)
CHANGES = (
    "duration_s=80",
    "fleet.settle_s=3",
    "log_steps=true",
    "outcomes.bootstrap=2",
    'plans=[{attack="lane_alias", share=1.0, start_after_s=[1.0, 2.0], duration_s=[60.0, 61.0]}]',
)


@pytest.fixture(scope="module")
def run(plain_net: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    from gpsec.pipeline.run import run_scenario

    folder = tmp_path_factory.mktemp("overtaking")
    net = plain_net(NODES, EDGES, "--opposites.guess", turnarounds=True)
    (folder / "cars.rou.xml").write_text(ROUTES)
    (folder / "run.sumocfg").write_text(
        f'<configuration><input><net-file value="{net}"/><route-files value="cars.rou.xml"/></input></configuration>'
    )
    scenario = load_scenario(folder / "run.sumocfg", [parse_set(change) for change in CHANGES])
    (folder / "out").mkdir()
    run_scenario(scenario, folder / "out", lambda progress: None)
    return folder / "out"


@pytest.fixture(scope="module")
def steps(run: Path) -> pd.DataFrame:
    return pd.read_parquet(run / "steps.parquet")


@pytest.fixture(scope="module")
def benign(steps: pd.DataFrame) -> pd.DataFrame:
    return steps[steps["plan"] == "none"]


def test_they_do_overtake(benign: pd.DataFrame) -> None:
    there = benign[benign["lane"] == "ba_0"]
    assert there["vehicle_id"].nunique() >= 3
    assert (there["y_m"].abs() < 1.0).any()


def test_steps_on_the_oncoming_lane_are_counted_and_told(run: Path, benign: pd.DataFrame) -> None:
    manifest = json.loads((run / "manifest.json").read_text())
    assert manifest["against_steps"] == (benign["lane"] == "ba_0").sum()
    assert any(f"{manifest['against_steps']} of" in note and "left out" in note for note in manifest["notes"])


def test_they_are_scored_by_no_detector_and_in_no_error(run: Path, steps: pd.DataFrame) -> None:
    events = pd.read_csv(run / "events.csv")
    attacked = steps[steps["attacked"] & (steps["lane"] == "ab_0")].groupby("vehicle_id").size() * 0.1
    counted = events[events["defence"] == events["defence"].iloc[0]].set_index("vehicle_id")["attack_seconds"]
    assert counted.to_dict() == pytest.approx(attacked.to_dict())


def test_nothing_jumps_where_they_cross_the_middle(benign: pd.DataFrame) -> None:
    residual = benign["residual_m"].dropna()
    assert len(residual) > 500
    assert residual.abs().max() < 1.6  # half a lane; to the oncoming lane and back it would be 3.2 m
    offset = benign[benign["lane"] == "ba_0"]["lane_offset_m"]
    assert offset.min() < -1.5  # the oncoming lane lies to their left


def test_gnss_is_used_all_the_time(benign: pd.DataFrame) -> None:
    """An alarm of the crossing would isolate it until the vehicle is back; one of them may have a false one."""
    isolated = [name for name in benign.columns if name.endswith("_isolated")]
    there = benign[benign["lane"] == "ba_0"].groupby("vehicle_id")[isolated].any()
    assert (there.sum() <= 1).all()
    assert not there["told+ukf_isolated"].any()


def test_a_spoofer_keeps_to_the_side_that_has_a_lane(steps: pd.DataFrame) -> None:
    """On their own lane the oncoming one is to their left; on that, their own is to their right."""
    spoofed = steps[steps["attacked"] & steps["fix_y_m"].notna()]
    for _, one in spoofed.groupby("vehicle_id"):
        side = -1.0 if one["lane"].iloc[0] == "ba_0" else 1.0
        for _, part in one.groupby("lane"):
            assert np.median(part["fix_y_m"] - part["y_m"]) == pytest.approx(side * 3.2, abs=0.5)
    begun = spoofed.groupby("vehicle_id")["lane"].first()
    assert {"ab_0", "ba_0"} <= set(begun)

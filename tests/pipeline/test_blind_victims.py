"""What the loop tells attacks of where cameras are blind, by way of the attack that heeds it."""

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest

from gpsec.scenario import load_scenario
from gpsec.scenario.overrides import parse_set
from gpsec.traffic.body import axle_distance

RATE_MPS, STEP_S, LENGTH_M = 0.5, 0.1, 5.0
NODES = 'id="n0" x="0" y="0"\nid="n1" x="200" y="0"\nid="n2" x="400" y="0"\nid="n3" x="200" y="200"'
EDGES = (
    'id="a" from="n0" to="n1" speed="8"\nid="b" from="n1" to="n2" speed="14"\n'
    'id="c" from="n3" to="n1" speed="8"\nid="d" from="n1" to="n3" speed="14"'
)
CHANGES = (
    "duration_s=50",
    "fleet.settle_s=2",
    'fleet.camera.visibility="clock"',
    "log_steps=true",
    "outcomes.bootstrap=2",
    'detection.detectors=["chi_square"]',
    'defences=[{detector="never", response="none"}]',
    f'plans=[{{attack="blind_drift", rate_mps={RATE_MPS}, share=1.0, start_after_s=[0, 1], duration_s=[90, 90]}}]',
)


def test_an_attack_is_told_the_camera_is_blind_from_bumper_in_to_rear_axle_out(
    plain_net: Callable[..., Path], tmp_path: Path, go: Callable[..., Path]
) -> None:
    net = plain_net(NODES, EDGES)
    (tmp_path / "cars.rou.xml").write_text(
        f'<routes><vType id="car" length="{LENGTH_M}"/><flow id="f" type="car" from="a" to="b" begin="0" period="4" '
        'number="5" departSpeed="max"/></routes>'
    )
    (tmp_path / "run.sumocfg").write_text(
        f'<configuration><input><net-file value="{net}"/><route-files value="cars.rou.xml"/></input></configuration>'
    )
    steps = pd.read_parquet(
        go(load_scenario(tmp_path / "run.sumocfg", [parse_set(change) for change in CHANGES])) / "steps.parquet"
    )
    inside = next(lane for lane in ElementTree.parse(net).iter("lane") if _crosses(lane))
    ends = [float(point.split(",")[0]) for point in inside.attrib["shape"].split()]
    both = steps[steps["plan"] == "none"].merge(steps[steps["attacked"]], on=["vehicle_id", "time_s"])
    moved = np.hypot(both["fix_x_m_y"] - both["fix_x_m_x"], both["fix_y_m_y"] - both["fix_y_m_x"])
    before = moved.groupby(both["vehicle_id"]).shift(1)
    rear = both["x_m_x"]
    front = rear + axle_distance(LENGTH_M)
    blind = (front > ends[0]) & (rear < ends[-1])
    # Not those whose bumper or axle is at an end of the junction, to a hand's breadth.
    sure = before.notna() & ((front - ends[0]).abs() > 0.1) & ((rear - ends[-1]).abs() > 0.1)
    assert (sure & blind).sum() > 50
    assert (sure & ~blind).sum() > 500
    assert both["vehicle_id"].nunique() == 5
    grown = (moved - before)[sure]
    assert grown[blind[sure]].to_numpy() == pytest.approx(RATE_MPS * STEP_S, abs=1e-9)
    assert grown[~blind[sure]].to_numpy() == pytest.approx(0.0, abs=1e-9)


def _crosses(lane: ElementTree.Element) -> bool:
    """Whether a lane inside the junction leads straight on."""
    norths = {point.split(",")[1] for point in lane.attrib["shape"].split()}
    return lane.attrib["id"].startswith(":") and len(norths) == 1

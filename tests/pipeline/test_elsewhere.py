"""Nets that lie elsewhere on the Earth, without a projection, and packed."""

import gzip
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from gpsec.scenario import Scenario, load_scenario
from gpsec.scenario.overrides import parse_set

# As in zone 32 of UTM: six digits east, seven north.
EAST_M, NORTH_M = 604_000.0, 5_792_000.0
CHANGES = (
    "duration_s=40",
    "fleet.settle_s=3",
    "outcomes.bootstrap=2",
    'detection.detectors=["cusum"]',
    'plans=[{attack="constant_bias", share=1.0, start_after_s=[2.0, 5.0], duration_s=[8.0, 9.0]}]',
)


@pytest.fixture
def road(tmp_path: Path, plain_net: Callable[..., Path]) -> Callable[[str, float, float], Scenario]:
    def make(name: str, east_m: float, north_m: float) -> Scenario:
        folder = tmp_path / "made" / name
        folder.mkdir(parents=True)
        at = ((0.0, 0.0), (250.0, 100.0), (600.0, 60.0))
        nodes = "\n".join(f'id="n{i}" x="{x + east_m}" y="{y + north_m}"' for i, (x, y) in enumerate(at))
        edges = 'id="a" from="n0" to="n1" numLanes="2" speed="15"\nid="b" from="n1" to="n2" numLanes="2" speed="15"'
        packed = gzip.compress(plain_net(nodes, edges).read_bytes())
        (folder / "road.net.xml.gz").write_bytes(packed)
        (folder / "road.rou.xml").write_text(
            '<routes><flow id="f" from="a" to="b" begin="0" period="4" number="8" departSpeed="max"/></routes>'
        )
        (folder / "road.sumocfg").write_text(
            '<configuration><input><net-file value="road.net.xml.gz"/><route-files value="road.rou.xml"/></input>'
            "</configuration>"
        )
        return load_scenario(folder, [parse_set(change) for change in CHANGES])

    return make


def test_where_a_net_lies_makes_no_difference(
    road: Callable[[str, float, float], Scenario], go: Callable[[Scenario], Path]
) -> None:
    here = go(road("here", 0.0, 0.0))
    far = go(road("far", EAST_M, NORTH_M))
    columns = ["vehicle_id", "attack", "defence", "start_s", "end_s", "detection_delay_s"]
    one, other = (pd.read_csv(folder / "events.csv") for folder in (here, far))
    assert len(one) >= 8
    pd.testing.assert_frame_equal(one[columns], other[columns])
    errors = ["rmse_xy_m", "rmse_cross_track_m", "max_cross_track_m"]
    # A float64 has a step of 1e-9 m there; filters turn that into less than a tenth of a millimetre.
    pd.testing.assert_frame_equal(one[errors], other[errors], atol=1e-4, rtol=0.0)

"""What a run says of vehicles that do not fit their lanes, or become many rows."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from gpsec.scenario import load_scenario
from gpsec.scenario.overrides import parse_set

# A road from a over b to c, and another one that makes b a junction with an extent.
NODES = """id="a" x="0" y="0"
id="b" x="300" y="0" radius="6"
id="c" x="600" y="200"
id="d" x="300" y="300"
id="e" x="300" y="-300" """
EDGES = """id="ab" from="a" to="b" numLanes="{n}" speed="14" width="{w}"
id="bc" from="b" to="c" numLanes="{n}" speed="14" width="3.2"
id="db" from="d" to="b"
id="be" from="b" to="e" """
ROAD = '<configuration><input><net-file value="{net}"/><route-files value="cars.rou.xml"/></input></configuration>'
BIAS = '{attack="constant_bias", bias_m=3.0, share=1.0, start_after_s=[0.0, 1.0], duration_s=[20.0, 21.0]}'
FLOW = '<flow id="{id}" type="{type}" from="ab" to="bc" begin="{begin}" period="9" number="4" {how}/>'

Notes = Callable[..., list[str]]


@pytest.mark.parametrize("stretched", [(), ("ab_0", "bc_0")])
def test_lanes_whose_length_is_not_that_of_their_shape_are_said(stretched: tuple[str, ...]) -> None:
    from gpsec.pipeline.remarks import beforehand

    ground = SimpleNamespace(options=SimpleNamespace(step_s=0.1), hd_map=SimpleNamespace(stretched=stretched))
    said = beforehand(ground)  # type: ignore[arg-type]
    assert [sentence.partition(" have")[0] for sentence in said] == ["2 lanes, such as 'ab_0',"] * bool(stretched)


@pytest.fixture
def notes(plain_net: Callable[..., Path], tmp_path: Path) -> Notes:
    """Return a function that runs such a road and gives what the run said; its tables are in `out`."""
    from gpsec.pipeline.run import run_scenario

    def run(types: str, flows: str, *options: str, lanes: int = 1, width_m: float = 3.2, sublanes: float = 0.8):
        net = plain_net(NODES, EDGES.format(n=lanes, w=width_m), *options)
        (tmp_path / "cars.rou.xml").write_text(f"<routes>{types}{flows}</routes>")
        (tmp_path / "run.sumocfg").write_text(ROAD.format(net=net))
        changes = (
            "duration_s=60",
            "fleet.settle_s=1",
            "outcomes.bootstrap=2",
            'detection.detectors=["cusum"]',
            f"traffic.lateral_resolution_m={sublanes}",
            f"plans=[{BIAS}]",
        )
        scenario = load_scenario(tmp_path / "run.sumocfg", [parse_set(change) for change in changes])
        (tmp_path / "out").mkdir()
        run_scenario(scenario, tmp_path / "out", lambda progress: None)
        return json.loads((tmp_path / "out" / "manifest.json").read_text())["notes"]

    return run


def flow(name: str, kind: str, begin: float, how: str = 'departSpeed="max"') -> str:
    return FLOW.format(id=name, type=kind, begin=begin, how=how)


def only(notes: list[str], about: str) -> str:
    found = [note for note in notes if about in note]
    assert len(found) == 1, notes
    return found[0]


def test_vehicles_wider_than_their_lane_are_named_with_their_share(notes: Notes, tmp_path: Path) -> None:
    types = '<vType id="car" width="1.8"/><vType id="van" width="2.1"/>'
    said = only(notes(types, flow("c", "car", 0) + flow("v", "van", 3), width_m=2.0), "touch a line")
    assert said.startswith("4 of 8 vehicles (50%)")
    assert "'v.0' of 2.10 m on 'ab_0' of 2.00 m" in said
    # It is true: without an attack, by the undefended estimate.
    table = pd.read_csv(tmp_path / "out" / "vehicles.csv")
    benign = table[(table["attack"] == "none") & (table["defence"] == "never+none")].set_index("vehicle_id")
    assert (benign.loc[["v.0", "v.1", "v.2", "v.3"], "outcome"] != "none").all()


def test_nothing_is_said_where_all_fit_and_nobody_jumps(notes: Notes) -> None:
    said = notes('<vType id="car" width="1.8"/>', flow("c", "car", 0))
    assert not [note for note in said if "rows" in note or "touch" in note or "left out" in note]


def test_jumps_over_junctions_without_lanes_are_named(notes: Notes, tmp_path: Path) -> None:
    said = notes('<vType id="car"/>', flow("c", "car", 0), "--no-internal-links")
    rows = only(said, "rows (id#2")
    assert re.match(r"4 vehicles became 8 rows .*: 4 after a jump from edge to edge: the net has no lanes inside", rows)
    shares = only(said, "of the vehicles themselves")
    benign, attacked = re.findall(r"(\d+) of (\d+) vehicles", shares)
    assert (benign[1], attacked[1]) == ("4", "4")
    events = pd.read_csv(tmp_path / "out" / "events.csv")
    assert events["vehicle_id"].nunique() > 4


def test_lane_changes_in_one_step_are_named(notes: Notes) -> None:
    types = '<vType id="slow" maxSpeed="5"/><vType id="fast" maxSpeed="14"/>'
    flows = flow("s", "slow", 0, 'departLane="0"') + flow("f", "fast", 4, 'departLane="0" departSpeed="max"')
    said = only(notes(types, flows, lanes=2, sublanes=0.0), "rows (id#2")
    assert "after a lane change in one step" in said
    assert "jump from edge to edge" not in said

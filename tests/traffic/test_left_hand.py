"""Where traffic keeps left, SUMO's lateral positions are mirrored: left of a command is the true left all the same."""

import subprocess
from pathlib import Path

import libsumo
import numpy as np
import pytest
import sumo
import sumolib

from .driven import CAR, LONG, Driven


@pytest.fixture
def left_hand(tmp_path):
    """Return a function that writes a scenario on a grid of two lanes a direction; it gives config and lanes."""
    program = Path(sumo.SUMO_HOME) / "bin" / "netgenerate"
    shape = ["--grid", "--grid.number=3", "--grid.length=200", "--default.lanenumber=2", "--no-turnarounds"]
    net = tmp_path / "grid.net.xml"
    subprocess.run([program, *shape, "--lefthand", "-o", net], check=True, capture_output=True)
    read = sumolib.net.readNet(str(net), withInternal=True)
    lanes = {lane.getID(): at for at, lane in enumerate(lane for edge in read.getEdges() for lane in edge.getLanes())}

    def write(routes):
        (tmp_path / "cars.rou.xml").write_text(f"<routes>{CAR}{LONG}{routes}</routes>")
        config = tmp_path / "run.sumocfg"
        inputs = '<net-file value="grid.net.xml"/><route-files value="cars.rou.xml"/>'
        config.write_text(f"<configuration><input>{inputs}</input></configuration>")
        return config, lanes

    return write


@pytest.mark.parametrize("lateral_m", [0.9, -0.9, 5.0, -7.0])
def test_a_vehicle_is_left_of_its_path_where_it_is_told_so(left_hand, lateral_m):
    """On A0B0, which leads east; near the junction the displacement is surplus, before that SUMO's."""
    with Driven(*left_hand('<vehicle id="v" type="car" depart="0" departLane="1" route="long"/>')) as driven:
        found, surplus = [], []
        for frame in driven.frames(14.0):
            driven.steer("v", np.clip(0.3 * (frame.step - 20), 0.0, abs(lateral_m)) * np.sign(lateral_m))
            if frame.step > 60 and driven.place["v"][0] < 188.0:
                found.append(driven.place["v"][1] - libsumo.lane.getShape("A0B0_1")[0][1])
                surplus += frame.carried.surplus_m.tolist()
        assert len(found) > 50
        assert np.abs(np.array(found) - lateral_m).max() < 0.005
        assert abs(lateral_m) < 2.0 or max(surplus, key=abs) * lateral_m > 1.0


@pytest.mark.parametrize("lateral_m", [2.2, -2.2])
def test_a_car_off_its_lane_turns_to_either_side(left_hand, lateral_m):
    """To turn left at B0 one comes from the left lane, that with the lowest number."""
    config, lanes = left_hand('<vehicle id="v" type="car" depart="0" departLane="1" route="left"/>')
    with Driven(config, lanes) as driven:
        paths = []
        for frame in driven.frames(100.0):
            driven.steer("v", np.clip(0.1 * frame.step, 0.0, abs(lateral_m)) * np.sign(lateral_m))
            paths += frame.carried.path.tolist()
        names = {index: name for name, index in lanes.items()}
        assert [names[path] for path in dict.fromkeys(paths)][:2] == ["A0B0_1", "A0B0_0"]
        assert frame.on_road == 0
        assert "v" not in driven.row

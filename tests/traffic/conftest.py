import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
import sumo
import sumolib

from gpsec.traffic.options import resolve_options
from gpsec.traffic.session import SumoSession
from gpsec.traffic.source import Frame

from .helpers import CAR, TRIP

Scenario = Callable[..., Path]


@pytest.fixture(scope="session")
def grid_net(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A net of 3 × 3 junctions 200 m apart, A0 … C2, with two lanes a direction."""
    net = tmp_path_factory.mktemp("grid") / "grid.net.xml"
    program = Path(sumo.SUMO_HOME) / "bin" / "netgenerate"
    shape = ["--grid", "--grid.number=3", "--grid.length=200", "--default.lanenumber=2", "--no-turnarounds"]
    subprocess.run([program, *shape, "-o", net], check=True, capture_output=True)
    return net


@pytest.fixture(scope="session")
def lane_index(grid_net: Path) -> dict[str, int]:
    net = sumolib.net.readNet(str(grid_net), withInternal=True)
    return {lane.getID(): at for at, lane in enumerate(lane for edge in net.getEdges() for lane in edge.getLanes())}


@pytest.fixture
def scenario(tmp_path: Path, grid_net: Path) -> Scenario:
    """Return a function that writes a scenario on the grid into a folder of its own and gives its configuration."""

    def write(routes: str = CAR + TRIP, additional: str = "", options: str = "") -> Path:
        folder = tmp_path / "scenario"
        folder.mkdir(exist_ok=True)
        (folder / "grid.net.xml").write_bytes(grid_net.read_bytes())
        (folder / "cars.rou.xml").write_text(f"<routes>{routes}</routes>")
        (folder / "more.add.xml").write_text(f"<additional>{additional}</additional>")
        config = folder / "run.sumocfg"
        config.write_text(
            '<configuration><input><net-file value="grid.net.xml"/><route-files value="cars.rou.xml"/>'
            f'<additional-files value="more.add.xml"/></input>{options}</configuration>'
        )
        return config

    return write


@pytest.fixture
def run(lane_index: dict[str, int]) -> Callable[..., tuple[list[Frame], SumoSession]]:
    """Run a configuration to its end and return its frames and the closed session."""

    def go(config, equip=lambda departure: True, lanes=lane_index, duration_s=None, seed=1, **asked):
        with SumoSession(resolve_options(config, seed=seed, **asked), lanes, equip) as session:
            frames = list(session.frames(duration_s))
        return frames, session

    return go

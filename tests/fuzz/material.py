"""What takes long to make and is damaged again and again: a net, a run, a recording."""

import subprocess
from dataclasses import dataclass
from pathlib import Path

import sumo

from gpsec import cli
from gpsec.hdmap.map import load_map
from gpsec.traffic.options import resolve_options
from gpsec.traffic.recording import record_traffic
from gpsec.traffic.recordingfile import on_net, save_recording
from gpsec.traffic.session import SumoSession
from tests.bad_input.worlds import CAR, FLOW, config, routes

SCENARIO = """
name = "whole"
sumocfg = "run.sumocfg"
[fleet]
settle_s = 0.0
[[defences]]
detector = "cusum"
response = "ukf"
[[plans]]
attack = "constant_bias"
bias_m = 2.4
share = 1.0
start_after_s = [2.0, 4.0]
"""


@dataclass(frozen=True)
class Material:
    """Files that are in order.

    Attributes:
        net: of SUMO, with the edges A0A1, A1A2 ….
        run: files of a finished run, by path.
        recording: of traffic.
    """

    net: bytes
    run: dict[str, bytes]
    recording: bytes


def make(folder: Path) -> Material:
    """Return the material; files go into the empty `folder`."""
    scenario = folder / "whole"
    scenario.mkdir()
    net = scenario / "grid.net.xml"
    program = Path(sumo.SUMO_HOME) / "bin" / "netgenerate"
    shape = ("--grid", "--grid.number=3", "--grid.length=150", "--default.lanenumber=2", "--no-turnarounds")
    subprocess.run([program, *shape, "-o", net], check=True, capture_output=True)
    (scenario / "cars.rou.xml").write_text(routes(CAR + FLOW))
    (scenario / "more.add.xml").write_text("<additional/>")
    (scenario / "run.sumocfg").write_text(config('<time><end value="40"/></time>'))
    (scenario / "gpsec.toml").write_text(SCENARIO)
    run = folder / "run"
    if cli.main(["run", str(scenario), "--out", str(run), "--no-report"]):
        raise RuntimeError("the run that is to be damaged has failed")
    traffic = folder / "traffic.npz"
    options = resolve_options(scenario / "run.sumocfg", seed=1)
    lanes = load_map(net, ()).lane_index
    with SumoSession(options, lanes, lambda departure: True) as session:
        save_recording(record_traffic(session, 15.0), traffic, on_net(net, len(lanes)))
    files = {str(path.relative_to(run)): path.read_bytes() for path in sorted(run.rglob("*")) if path.is_file()}
    return Material(net.read_bytes(), files, traffic.read_bytes())

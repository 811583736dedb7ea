"""Routes: random trips by SUMO's tools, or flows along each road of a net on which no trip is possible."""

from pathlib import Path
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

import numpy as np

from gpsec.core.errors import GpsecError, MachineError, retold
from gpsec.core.processes import ended_early
from gpsec.hdmap.net import Lane
from gpsec.sumo.tools import run_tool

# How much likelier a trip begins or ends at the edge of the net than inside it.
_FRINGE_FACTOR = 5.0
_NONE_FOUND = "Trips couldn't be generated"
_DRIVEN = 'type="traffic" departLane="best" departSpeed="max" departPos="base"'


def random_trips(
    net_file: Path, types: Path, folder: Path, period_s: float, duration_s: float, seed: int
) -> tuple[str, int]:
    """Return a route file with random trips, and the number of its vehicles: none where the net allows no trip.

    Args:
        net_file: absolute path of the net.
        types: additional file with the distribution ``traffic``.
        folder: for what the tools write.
        period_s: mean time between two departures.
        duration_s: for how long vehicles depart.
        seed: of the tools.

    Raises:
        GpsecError: the tools do not take the net.
        MachineError: they crash, are killed, or run out of memory.
    """
    routes = folder / "trips.rou.xml"
    arguments = [
        "--net-file", str(net_file),
        "--additional-files", str(types),
        "--output-trip-file", str(folder / "trips.xml"),
        "--route-file", str(routes),
        "--end", f"{duration_s:g}",
        "--period", f"{period_s:g}",
        "--seed", str(seed),
        "--edge-permission", "passenger",
        "--fringe-factor", f"{_FRINGE_FACTOR:g}",
        "--allow-fringe",
        "--lanes",
        "--trip-attributes", _DRIVEN,
        "--random-depart",
        "--validate",
    ]  # fmt: skip
    done = run_tool("randomTrips.py", arguments, folder)
    if _NONE_FOUND in done.stderr:
        return "", 0
    if done.returncode < 0:
        raise MachineError(f"{net_file}: {ended_early('randomTrips.py', done.returncode, 'a fault of its own')}")
    if done.returncode != 0 or not routes.is_file():
        words = (done.stderr.strip() or done.stdout.strip() or "no reason given").splitlines()[-1]
        raise GpsecError(f"{net_file}: SUMO's randomTrips.py finds no demand for it: {retold(words)}")
    root = ElementTree.parse(routes).getroot()
    for kind in root.findall("vType") + root.findall("vTypeDistribution"):
        root.remove(kind)  # they are in `types`
    ElementTree.indent(root, "    ")
    text = ElementTree.tostring(root, encoding="unicode", xml_declaration=True)
    return text + "\n", len(root.findall("vehicle"))


# A shorter road is passed in a few seconds.
SHORTEST_FLOW_M = 50.0


def length_m(lane: Lane) -> float:
    """Return the length of a lane's centre line."""
    return float(np.hypot(*np.diff(lane.shape_m, axis=0).T).sum())


def straight_flows(lanes: list[Lane], period_s: float, duration_s: float) -> tuple[str, int]:
    """Return a route file with a flow from the beginning to the end of each road, and how many there are.

    Vehicles depart every `period_s` on average on all roads together, on each in proportion to its lanes.
    """
    count: dict[str, int] = {}
    for lane in lanes:
        if length_m(lane) >= SHORTEST_FLOW_M:
            edge = lane.lane_id.rpartition("_")[0]
            count[edge] = count.get(edge, 0) + 1
    total = sum(count.values())
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', "<routes>"]
    for number, (edge, width) in enumerate(sorted(count.items())):
        rate = width / total / period_s
        road = quoteattr(edge)
        lines.append(
            f'    <flow id="road{number}" type="traffic" from={road} to={road} begin="0" end="{duration_s:g}" '
            f'period="exp({rate:.5f})" departLane="best" departSpeed="max" departPos="base"/>'
        )
    return "\n".join([*lines, "</routes>", ""]), len(count)

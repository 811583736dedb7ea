"""Random trips with SUMO's randomTrips.py and duarouter."""

from pathlib import Path
from xml.etree import ElementTree

from gpsec.core.errors import GpsecError, MachineError, retold
from gpsec.core.processes import ended_early
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

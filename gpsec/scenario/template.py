"""The files of a new scenario: what netedit opens, SUMO runs and gpsec evaluates."""

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import shapely
import shapely.ops

from gpsec.core.errors import GpsecError
from gpsec.hdmap.net import Lane

# The example zone: this much on either side of the lane, along the middle half of it but no longer than this.
_BESIDE_M, _LONGEST_M = 20.0, 200.0
_SHORTEST_M = 30.0
_HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'


def netedit_config(net: str, additional: Iterable[str], routes: Iterable[str]) -> str:
    """Return the ``.netecfg`` that opens these files; paths are relative to it."""
    return (
        f"{_HEAD}<neteditConfiguration>\n"
        "    <input>\n"
        f"        <sumo-net-file value={quoteattr(net)}/>\n"
        f"        <additional-files value={quoteattr(','.join(additional))}/>\n"
        f"        <route-files value={quoteattr(','.join(routes))}/>\n"
        "    </input>\n"
        "</neteditConfiguration>\n"
    )


def sumo_config(net: str, additional: Iterable[str], routes: Iterable[str], end_s: float) -> str:
    """Return the ``.sumocfg`` that runs these files to `end_s`; paths are relative to it."""
    return (
        f"{_HEAD}<sumoConfiguration>\n"
        "    <input>\n"
        f"        <net-file value={quoteattr(net)}/>\n"
        f"        <route-files value={quoteattr(','.join(routes))}/>\n"
        f"        <additional-files value={quoteattr(','.join(additional))}/>\n"
        "    </input>\n"
        "    <time>\n"
        '        <begin value="0"/>\n'
        f'        <end value="{end_s:g}"/>\n'
        '        <step-length value="0.1"/>\n'
        "    </time>\n"
        "    <processing>\n"
        '        <lateral-resolution value="0.8"/>\n'
        '        <time-to-teleport value="180"/>\n'
        '        <collision.action value="warn"/>\n'
        "    </processing>\n"
        "</sumoConfiguration>\n"
    )


def example_zone(lane: Lane) -> str:
    """Return an additional file with an attack zone about the middle of a lane."""
    line = shapely.LineString(lane.shape_m)
    half = min(0.25 * line.length, 0.5 * _LONGEST_M)
    middle = shapely.ops.substring(line, 0.5 * line.length - half, 0.5 * line.length + half)
    area = middle.buffer(_BESIDE_M, cap_style="flat").simplify(0.5)
    if area.geom_type != "Polygon":  # a lane that winds into itself
        area = middle.buffer(_BESIDE_M).convex_hull
    corners = " ".join(f"{x:.2f},{y:.2f}" for x, y in np.round(area.exterior.coords, 2).tolist())
    return (
        f"{_HEAD}<additional>\n"
        '    <poly id="example_zone" type="gpsec.attack" color="255,60,60,80" fill="1" layer="10.00" '
        f'shape="{corners}">\n'
        '        <param key="gpsec.attack" value="constant_bias"/>\n'
        '        <param key="gpsec.bias_m" value="2.4"/>\n'
        '        <param key="gpsec.share" value="0.5"/>\n'
        "    </poly>\n"
        "</additional>\n"
    )


def busiest_lane(lanes: Iterable[Lane], edge_of: Mapping[str, str], used: Counter[str]) -> Lane:
    """Return the lane for the example zone: of the roads that are long enough, the one that most vehicles take.

    Args:
        lanes: of the net, without those inside junctions.
        edge_of: id of the edge of each lane.
        used: vehicles on each edge; where they are not known, the longest lane is taken.

    Raises:
        GpsecError: there is no lane.
    """
    measured = [(lane, float(shapely.LineString(lane.shape_m).length)) for lane in lanes]
    if not measured:
        raise GpsecError("expected a lane for the example zone, found none")
    enough = [pair for pair in measured if pair[1] >= _SHORTEST_M] or measured
    return max(enough, key=lambda pair: (used[edge_of[pair[0].lane_id]], pair[1], pair[0].lane_id))[0]


def toml(name: str, sumocfg: str, net: str, duration_s: float, schema: str) -> str:
    """Return a `gpsec.toml` with comments for somebody who has not seen one."""
    return f"""#:schema ./{schema}
# What is evaluated on {Path(net).name}. Keys that are not here keep their defaults; docs/scenario.md has them all.
# gpsec check {name} says whether all is in order, gpsec run {name} runs it.

sumocfg = "{sumocfg}"
duration_s = {duration_s:.1f} # simulated seconds
seed = 1 # of SUMO and of all noise: the same seed gives the same tables

[fleet]
equipped_share = 1.0 # share of the vehicles that are automated
profile = "carla" # whose sensors they have: gpsec list profiles; or shares, {{ dsd = 0.5, carla = 0.5 }}

# [world] # what filters and detectors do not know: docs/world.md has the keys, gpsec stress {name} tries them all
# gnss_white_factor = 1.5

# Detectors to score (gpsec list detectors), and the rates of false alarms at which each is scored.
[detection]
detectors = ["chi_square", "cusum", "isolation_forest", "lstm_glr", "innovation", "joint"]
rates = ["0.1/h", "1e-3/sample"]

# A defence is a detector and what is done on its alarm. The undefended vehicle, never+none, is always there.
[[defences]]
detector = "told" # told at once when an attack begins and ends
response = "ukf"

[[defences]]
detector = "cusum"
response = "ukf"

[[defences]]
detector = "lstm_glr" # the paper's UKF behind our form of its LSTM
response = "ukf"
rate = "1e-3/sample" # ten times an hour and more; without it 0.1/h, which one would drive with

[[defences]]
detector = "joint" # innovations of GNSS together with the camera's residual
response = "ukf5_rollback" # starts again from before the attack, and knows its odometer

# Attack plans: who is attacked, when, and how; gpsec list attacks. The zone in {Path(sumocfg).stem}.add.xml is one
# more, and so are those that you draw in netedit (polygons and points of type gpsec.attack).
[[plans]]
attack = "constant_bias"
share = 0.5 # of the fleet
bias_m = 2.4

[[plans]]
attack = "stealth"
share = 0.5
start_after_s = [0.0, 30.0] # seconds from when a vehicle has settled to its attack, drawn for each
duration_s = [10.0, 30.0]

# [[plans]]
# attack = "drift"
# name = "buses_only"
# vehicle_types = ["bus_calm", "bus_normal"]
# rate_mps = 0.3
"""
